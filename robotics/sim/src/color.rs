//! Colours of things, as a world file writes them.
//!
//! The camera alone decides how light changes a colour.

/// A colour in sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Color {
    /// Red.
    pub r: u8,
    /// Green.
    pub g: u8,
    /// Blue.
    pub b: u8,
}

/// The names that a world file may use instead of `#rrggbb`.
pub(crate) const NAMES: [(&str, Color); 14] = [
    ("white", Color::new(245, 245, 242)),
    ("silver", Color::new(190, 192, 196)),
    ("gray", Color::new(128, 130, 134)),
    ("black", Color::new(32, 33, 36)),
    ("red", Color::new(204, 41, 36)),
    ("orange", Color::new(240, 124, 24)),
    ("yellow", Color::new(242, 201, 32)),
    ("green", Color::new(46, 148, 70)),
    ("teal", Color::new(26, 143, 143)),
    ("blue", Color::new(38, 92, 190)),
    ("purple", Color::new(124, 64, 168)),
    ("pink", Color::new(232, 120, 160)),
    ("brown", Color::new(122, 82, 48)),
    ("beige", Color::new(222, 208, 178)),
];

impl Color {
    /// Creates a colour from its components, from 0 to 255.
    pub const fn new(r: u8, g: u8, b: u8) -> Self {
        Self { r, g, b }
    }

    /// Parses `#rrggbb` or one of the known names; `None` for anything else.
    pub fn parse(text: &str) -> Option<Self> {
        if let Some((_, color)) = NAMES.iter().find(|(name, _)| *name == text) {
            return Some(*color);
        }
        let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6)?;
        if !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
            return None;
        }
        let [_, r, g, b] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
        Some(Self::new(r, g, b))
    }

    /// Returns the relative luminance of a surface of this colour, from 0 for black to 1 for white: linear
    /// light by IEC 61966-2-1, weighted by ITU-R BT.709.
    pub fn luminance(self) -> f64 {
        let linear = |part: u8| {
            let part = f64::from(part) / 255.0;
            if part <= 0.04045 {
                part / 12.92
            } else {
                libm::pow((part + 0.055) / 1.055, 2.4)
            }
        };
        0.2126 * linear(self.r) + 0.7152 * linear(self.g) + 0.0722 * linear(self.b)
    }
}

#[cfg(test)]
mod tests {
    use super::{Color, NAMES};

    #[test]
    fn a_colour_is_six_hexadecimal_digits_or_a_name() {
        assert_eq!(Color::parse("#1a2B3c"), Some(Color::new(0x1a, 0x2b, 0x3c)));
        for (name, color) in NAMES {
            assert_eq!(Color::parse(name), Some(color));
        }
        for wrong in [
            "", "#12345", "#1234567", "#12345g", "#+12345", "123456", "Red", "#é1234",
        ] {
            assert_eq!(Color::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn luminance_is_linear_in_light() {
        for (text, expected) in [
            ("#000000", 0.0),
            ("#ffffff", 1.0),
            ("#ff0000", 0.2126),
            ("#bcbcbc", 0.503),
            ("#0a0a0a", 0.00304),
        ] {
            let found = Color::parse(text).expect("a colour").luminance();
            assert!((found - expected).abs() < 0.001, "{text}: {found}");
        }
    }
}
