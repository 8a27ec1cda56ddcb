//! What a minder's process is asked to do.

use std::{io, str::FromStr, time::Duration};

use super::Minding;
use crate::line::Address;

/// What makes a program mind a line, and which.
pub const ASKED: &str = "ORIENTEER_MIND_LINE";
/// What the minder says when it has the device.
pub const OPEN: &str = "open";

/// What the minder's process is asked to do, as it is handed over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Order {
    pub address: Address,
    pub baud: u32,
    pub minding: Minding,
}

impl Order {
    /// As it is handed over.
    pub fn text(&self) -> String {
        let stop: String = self.minding.stop.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("{} {} {stop} {}", self.baud, self.minding.silence.as_millis(), self.address)
    }
}

impl FromStr for Order {
    type Err = io::Error;

    fn from_str(text: &str) -> io::Result<Self> {
        let strange = || io::Error::new(io::ErrorKind::InvalidInput, format!("`{ASKED}` is not as a client writes it: `{text}`"));
        let parts: Vec<_> = text.splitn(4, ' ').collect();
        let [baud, silence, stop, address] = parts[..] else { return Err(strange()) };
        let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
        let stop: Option<Vec<u8>> = stop.as_bytes().chunks(2).map(byte).collect();
        let silence = Duration::from_millis(silence.parse().map_err(|_| strange())?);
        let minding = Minding { stop: stop.ok_or_else(strange)?, silence };
        Ok(Self { address: address.parse().map_err(|_| strange())?, baud: baud.parse().map_err(|_| strange())?, minding })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_order_comes_over_as_it_was_given() {
        for address in ["/dev/serial/by id/a b", "tcp://[::1]:8101"] {
            let minding = Minding { stop: vec![0, 145, 255], silence: Duration::from_millis(250) };
            let order = Order { address: address.parse().unwrap(), baud: 115_200, minding };
            assert_eq!(order.text().parse::<Order>().unwrap(), order);
        }
        for strange in ["", "1 2 3", "x 1 00 /dev/a", "1 x 00 /dev/a", "1 1 0g /dev/a", "1 1 é0 /dev/a", "1 1 00 nowhere"] {
            assert!(strange.parse::<Order>().is_err(), "{strange}");
        }
    }
}
