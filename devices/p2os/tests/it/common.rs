//! Helpers of the tests: hexadecimal vectors, and decoding and encoding of any packet.

use jde_p2os::{Command, Config, Encoders, Error, LaserPacket, Names, Packet, SerialAux, SimState, Sip};

/// Returns the lines of a vector file: bytes in hexadecimal, then a description.
pub(crate) fn vectors(text: &str) -> impl Iterator<Item = (Vec<u8>, &str)> {
    text.lines().map(|line| {
        let (bytes, description) = line.split_once("  ").expect("bytes, two blanks, a description");
        (hex(bytes), description)
    })
}

pub(crate) fn hex(text: &str) -> Vec<u8> {
    let digits: Vec<u8> = text
        .chars()
        .map(|digit| digit.to_digit(16).expect("hexadecimal") as u8)
        .collect();
    digits.chunks(2).map(|pair| pair[0] << 4 | pair[1]).collect()
}

/// Decodes a robot's packet by its kind, and encodes it again.
pub(crate) fn reencode(packet: &Packet) -> Result<Packet, Error> {
    match packet.id() {
        0..=1 => Ok(*packet),
        2 => Names::from_packet(packet)?.to_packet(),
        0x20 => Config::from_packet(packet)?.to_packet(),
        0x32 | 0x33 => Sip::from_packet(packet)?.to_packet(),
        0x60 | 0x61 => LaserPacket::from_packet(packet)?.to_packet(),
        0x62 => SimState::from_packet(packet)?.to_packet(),
        0x90 => Ok(Encoders::from_packet(packet)?.to_packet()),
        _ => SerialAux::from_packet(packet)?.to_packet(),
    }
}

/// Decodes a client's packet, and encodes it again.
pub(crate) fn reencode_command(packet: &Packet) -> Result<Packet, Error> {
    Command::from_packet(packet).to_packet()
}
