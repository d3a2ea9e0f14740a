//! The attachment of each message: its number, its time and its publication.

/// Encodes the attachment of rmw_zenoh in Zenoh's serialization: sequence number, wall-clock time in ns, and
/// the identifier of the publication after its length.
pub(crate) fn attachment(sequence: i64, nanos: i64, gid: [u8; 16]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(33);
    bytes.extend(sequence.to_le_bytes());
    bytes.extend(nanos.to_le_bytes());
    bytes.push(gid.len() as u8);
    bytes.extend(gid);
    bytes
}

/// Returns an identifier that no other publication has, from those of the session and the topic.
pub(crate) fn gid(session: [u8; 16], number: usize) -> [u8; 16] {
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
    }

    #[test]
    fn publications_and_sessions_have_distinct_identifiers() {
        let session = [9; 16];
        assert_ne!(gid(session, 1), gid(session, 2));
        assert_ne!(gid(session, 1), gid([8; 16], 1));
    }
}
