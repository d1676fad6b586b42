//! Words of fixed size.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

/// UTF-8 text of at most [`Text::CAPACITY`] bytes, filled up with zeros.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Text/v1")]
pub struct Text {
    bytes: [u8; 128],
}

impl Text {
    /// The longest text, in bytes.
    pub const CAPACITY: usize = 128;

    /// Keeps `text`, cut at the last whole character that fits. A NUL ends the text.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let end = text.find('\0').unwrap_or(text.len());
        let end = text.floor_char_boundary(end.min(Self::CAPACITY));
        let mut bytes = [0; Self::CAPACITY];
        bytes[..end].copy_from_slice(&text.as_bytes()[..end]);
        Self { bytes }
    }

    /// The text; whatever precedes the first byte that is no UTF-8.
    #[must_use]
    pub fn as_str(&self) -> &str {
        let end = self.bytes.iter().position(|byte| *byte == 0).unwrap_or(Self::CAPACITY);
        match std::str::from_utf8(&self.bytes[..end]) {
            Ok(text) => text,
            Err(error) => std::str::from_utf8(&self.bytes[..error.valid_up_to()]).unwrap_or_default(),
        }
    }
}

impl Default for Text {
    fn default() -> Self {
        Self::zeroed()
    }
}

impl From<&str> for Text {
    fn from(text: &str) -> Self {
        Self::new(text)
    }
}

impl std::fmt::Debug for Text {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        std::fmt::Debug::fmt(self.as_str(), formatter)
    }
}

impl std::fmt::Display for Text {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_short_text_and_cuts_long_text_between_characters() {
        assert_eq!(Text::new("brake friction low").as_str(), "brake friction low");
        assert_eq!(Text::new("").as_str(), "");
        let long = "µ".repeat(100);
        assert_eq!(Text::new(&long).as_str(), "µ".repeat(64));
        let odd = format!("a{}", "µ".repeat(100));
        assert_eq!(Text::new(&odd).as_str(), format!("a{}", "µ".repeat(63)));
        assert_eq!(Text::new("a\0b").as_str(), "a");
    }

    #[test]
    fn survives_bytes_that_are_no_text() {
        let mut text = Text::new("good");
        text.bytes[4] = 0xff;
        assert_eq!(text.as_str(), "good");
    }
}
