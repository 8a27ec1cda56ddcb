//! Where a device is found.

use std::{fmt, path::PathBuf, str::FromStr};

/// Where a device is found.
///
/// ```
/// use orienteer_hardware::line::Address;
///
/// let address: Address = "tcp://192.168.0.7:8101".parse()?;
/// assert_eq!(address, Address::Tcp { host: "192.168.0.7".into(), port: 8101 });
/// let address: Address = "/dev/ttyUSB0".parse()?;
/// assert_eq!(address.to_string(), "/dev/ttyUSB0");
/// assert!("tcp://192.168.0.7".parse::<Address>().is_err());
/// # Ok::<(), orienteer_hardware::line::AddressError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Address {
    /// A serial port.
    Serial {
        /// Its device file.
        path: PathBuf,
    },
    /// A port of a computer in the network: the robot's own, or one that passes a serial line on.
    Tcp {
        /// Name or number of the computer.
        host: String,
        /// The port.
        port: u16,
    },
}

/// This is no address of a device.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is no port: {why}")]
pub struct AddressError {
    text: String,
    why: &'static str,
}

impl FromStr for Address {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        let refuse = |why| Err(AddressError { text: text.to_owned(), why });
        if text.contains(char::is_control) {
            return refuse("there are characters in it that nobody can see");
        }
        let Some(place) = text.strip_prefix("tcp://") else {
            return match text {
                _ if text.contains("://") => refuse("only `tcp://` is known"),
                _ if text.starts_with('/') && !text.ends_with('/') => Ok(Self::Serial { path: text.into() }),
                _ => refuse("a serial port has its whole path, as `/dev/ttyUSB0`; one of the network is `tcp://host:port`"),
            };
        };
        let Some((host, port)) = place.rsplit_once(':') else { return refuse("there is no `:port` behind the host") };
        // In a URL the colons of a number of version 6 stand in brackets; to be resolved it needs to be without.
        let host = host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host);
        match port.parse() {
            Ok(port) if port > 0 && !host.is_empty() => Ok(Self::Tcp { host: host.to_owned(), port }),
            Ok(_) if host.is_empty() => refuse("there is no host before the `:`"),
            _ => refuse("a network port is a number from 1 to 65535"),
        }
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial { path } => write!(f, "{}", path.display()),
            Self::Tcp { host, port } if host.contains(':') => write!(f, "tcp://[{host}]:{port}"),
            Self::Tcp { host, port } => write!(f, "tcp://{host}:{port}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_come_back() {
        for text in ["/dev/ttyUSB0", "/dev/serial/by-id/usb-FTDI_x-if00-port0", "tcp://localhost:8101", "tcp://[::1]:8101"] {
            assert_eq!(text.parse::<Address>().map(|address| address.to_string()), Ok(text.to_owned()));
        }
    }

    #[test]
    fn what_is_no_address_is_refused_with_the_reason() {
        for (text, why) in [
            ("", "whole path"),
            ("ttyUSB0", "whole path"),
            ("/dev/", "whole path"),
            ("udp://host:1", "only `tcp://`"),
            ("tcp://host", "no `:port`"),
            ("tcp://:8101", "no host"),
            ("tcp://host:0", "1 to 65535"),
            ("tcp://host:70000", "1 to 65535"),
            ("tcp://host:x", "1 to 65535"),
            ("/dev/tty\0USB", "nobody can see"),
            ("tcp://ho\nst:1", "nobody can see"),
        ] {
            let told = text.parse::<Address>().map_err(|error| error.to_string());
            assert!(told.as_ref().is_err_and(|told| told.contains(why)), "{text}: {told:?}");
        }
    }
}
