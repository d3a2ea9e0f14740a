//! The attachment of each message, request and response: its number, its time, and the entity that sent it.

use std::time::{SystemTime, UNIX_EPOCH};

/// Identifies a publication or a client.
pub(crate) type Gid = [u8; 16];

/// Number of bytes: two numbers, the length of the identifier, and the identifier.
const BYTES: usize = 33;

/// Encodes the attachment of rmw_zenoh in Zenoh's serialization: sequence number, wall-clock time in ns, and
/// the identifier of the sender after its length.
pub(crate) fn attachment(sequence: i64, nanos: i64, gid: Gid) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(BYTES);
    bytes.extend(sequence.to_le_bytes());
    bytes.extend(nanos.to_le_bytes());
    bytes.push(gid.len() as u8);
    bytes.extend(gid);
    bytes
}

/// Encodes an attachment with the present time.
pub(crate) fn attachment_now(sequence: i64, gid: Gid) -> Vec<u8> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    attachment(sequence, since.as_nanos() as i64, gid)
}

/// Returns the sequence number and the identifier of an attachment; `None` if it is no such one.
pub(crate) fn parse(bytes: &[u8]) -> Option<(i64, Gid)> {
    let sequence = bytes.first_chunk().copied().map(i64::from_le_bytes)?;
    let gid = bytes.get(BYTES - 16..BYTES)?.try_into().ok()?;
    Some((sequence, gid))
}

/// Returns an identifier that no other entity has, from those of the session and the entity.
pub(crate) fn gid(session: Gid, number: usize) -> Gid {
    let number = (number as u128).rotate_right(32);
    (u128::from_le_bytes(session) ^ number).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_attachment_has_sequence_time_and_length_prefixed_identifier() {
        let bytes = attachment(2, 0x0102, [7; 16]);
        assert_eq!(bytes[..8], [2, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes[8..16], [2, 1, 0, 0, 0, 0, 0, 0]);
        assert_eq!(bytes[16..], [&[16][..], &[7; 16]].concat());
        assert_eq!(parse(&bytes), Some((2, [7; 16])));
        assert_eq!(parse(&bytes[..32]), None);
    }

    #[test]
    fn entities_and_sessions_have_distinct_identifiers() {
        let session = [9; 16];
        assert_ne!(gid(session, 1), gid(session, 2));
        assert_ne!(gid(session, 1), gid([8; 16], 1));
    }
}
