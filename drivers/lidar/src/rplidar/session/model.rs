//! What a lidar says of itself, and what follows from its model by SLAMTEC's data sheets.

use core::fmt;

use crate::rplidar::samples::Format;

/// Model, firmware, hardware and serial number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Model {
    model: u8,
    firmware: [u8; 2],
    /// 32 hexadecimal digits.
    pub(super) serial_number: String,
}

impl Model {
    /// Reads the reply to `GET_INFO`: model, firmware (the part after the point first), hardware and 16 bytes of a
    /// serial number.
    pub(super) fn read(data: &[u8]) -> Option<Self> {
        let &[model, minor, major, _, ref serial_number @ ..] = data else {
            return None;
        };
        let digits = serial_number.iter().map(|byte| format!("{byte:02X}"));
        (serial_number.len() == 16).then(|| Self {
            model,
            firmware: [major, minor],
            serial_number: digits.collect(),
        })
    }

    /// The number of its series: 1 to 3 are A1 to A3, 4 is C1, 6 to 8 are S1 to S3.
    pub(super) fn series(&self) -> u8 {
        self.model >> 4
    }

    /// Whether it says which modes it has.
    pub(super) fn has_modes(&self) -> bool {
        self.series() >= 4 || self.firmware >= [1, 24]
    }

    /// Whether it knows `EXPRESS_SCAN`.
    pub(super) fn has_express(&self) -> bool {
        self.series() >= 4 || self.firmware >= [1, 17]
    }

    /// The least and the greatest distance, m, that it can measure and send in a format.
    pub(super) fn limits(&self, format: Format) -> [f32; 2] {
        let [least, greatest] = match self.series() {
            0 | 1 => [0.15, 12.0],
            2 => [0.15, 16.0],
            3 => [0.15, 25.0],
            4 | 5 => [0.05, 12.0],
            7 => [0.05, 30.0],
            _ => [0.05, 40.0],
        };
        // Rounded down to centimetres.
        [least, greatest.min((format.greatest() / 10.0).floor() / 100.0)]
    }
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (series, number) = match self.series() {
            series @ 0..4 => ('A', series),
            series @ 4..6 => ('C', series - 3),
            series => ('S', series - 5),
        };
        let ([major, minor], serial_number) = (self.firmware, &self.serial_number);
        write!(
            f,
            "RPLIDAR {series}{number}M{}, firmware {major}.{minor:02}, serial number {serial_number}",
            self.model & 0xf
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_is_named_as_its_maker_does() {
        let name = |model: u8| {
            let mut data = vec![model, 29, 1, 7];
            data.extend(0xa0..0xb0);
            Model::read(&data).expect("information").to_string()
        };
        let rest = "firmware 1.29, serial number A0A1A2A3A4A5A6A7A8A9AAABACADAEAF";
        for (model, expected) in [
            (0x18, "A1M8"),
            (0x2c, "A2M12"),
            (0x31, "A3M1"),
            (0x41, "C1M1"),
            (0x61, "S1M1"),
        ] {
            assert_eq!(name(model), format!("RPLIDAR {expected}, {rest}"));
        }
        assert_eq!(Model::read(&[0x18; 19]), None);
        assert_eq!(Model::read(&[0x18; 21]), None);
    }
}
