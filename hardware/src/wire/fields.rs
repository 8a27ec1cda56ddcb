//! Reading the fields of a packet one after the other.

use super::PacketError;

/// What is left of a packet. Numbers are little-endian unless a method's name says otherwise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fields<'a>(pub &'a [u8]);

impl<'a> Fields<'a> {
    fn take<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], PacketError> {
        let (head, tail) = self.0.split_first_chunk::<N>().ok_or(PacketError::TooShort { field })?;
        self.0 = tail;
        Ok(*head)
    }

    /// An unsigned byte.
    pub fn u8(&mut self, field: &'static str) -> Result<u8, PacketError> {
        self.take::<1>(field).map(|[byte]| byte)
    }

    /// An unsigned number of two bytes.
    pub fn u16(&mut self, field: &'static str) -> Result<u16, PacketError> {
        self.take(field).map(u16::from_le_bytes)
    }

    /// A signed number of two bytes.
    pub fn i16(&mut self, field: &'static str) -> Result<i16, PacketError> {
        self.take(field).map(i16::from_le_bytes)
    }

    /// A signed byte.
    pub fn i8(&mut self, field: &'static str) -> Result<i8, PacketError> {
        self.take(field).map(i8::from_be_bytes)
    }

    /// An unsigned number of two bytes, the high one first.
    pub fn u16_be(&mut self, field: &'static str) -> Result<u16, PacketError> {
        self.take(field).map(u16::from_be_bytes)
    }

    /// A signed number of two bytes, the high one first.
    pub fn i16_be(&mut self, field: &'static str) -> Result<i16, PacketError> {
        self.take(field).map(i16::from_be_bytes)
    }

    /// Text that a zero ends.
    pub fn text(&mut self, field: &'static str) -> Result<&'a [u8], PacketError> {
        let end = self.0.iter().position(|byte| *byte == 0).ok_or(PacketError::TooShort { field })?;
        let (text, tail) = self.0.split_at(end);
        self.0 = &tail[1..];
        Ok(text)
    }

    /// Bytes behind a byte that says how many there are.
    pub fn counted(&mut self, field: &'static str) -> Result<&'a [u8], PacketError> {
        let count = usize::from(self.u8(field)?);
        let (bytes, tail) = self.0.split_at_checked(count).ok_or(PacketError::TooShort { field })?;
        self.0 = tail;
        Ok(bytes)
    }

    /// Passes over bytes that nobody here has a use for.
    pub fn skip(&mut self, count: usize, field: &'static str) -> Result<(), PacketError> {
        self.0 = self.0.get(count..).ok_or(PacketError::TooShort { field })?;
        Ok(())
    }

    /// True if nothing is left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
