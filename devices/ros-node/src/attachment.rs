//! The attachment of each message, request and response: its number, its time, and the entity that sent it.

use std::time::{SystemTime, UNIX_EPOCH};

use twox_hash::XxHash3_128;

/// Identifies a publication or a client.
pub(crate) type Gid = [u8; 16];

/// Number of bytes: two numbers, the length of the identifier, and the identifier.
const ATTACHMENT_BYTES: usize = 33;

/// Encodes the attachment of rmw_zenoh in Zenoh's serialization: sequence number, wall-clock time in ns, and
/// the identifier of the sender after its length.
pub(crate) fn attachment(sequence: i64, nanos: i64, gid: Gid) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(ATTACHMENT_BYTES);
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
    let gid = bytes
        .get(ATTACHMENT_BYTES - 16..ATTACHMENT_BYTES)?
        .try_into()
        .ok()?;
    Some((sequence, gid))
}

/// Returns the identifier of the entity that a token announces, as rmw_zenoh computes it: the hash XXH3 of the token, 128
/// bits.
pub(crate) fn gid(token: &str) -> Gid {
    XxHash3_128::oneshot(token.as_bytes()).to_le_bytes()
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
    fn an_entity_has_the_identifier_that_ros_computes_from_its_token() {
        // From `simplified_XXH3_128bits` of rmw_zenoh_cpp 0.2.10.
        let topic = "@ros2_lv/3/fe1bcc09d7b2c5ab8d9a1e7ce3a2b0d4/0/1/MP/%/%fleet/pioneer/%fleet%odom/nav_msgs::msg::dds_::Odometry_/\
            RIHS01_3cc97dc7f03e33d11a4e1c5a4e5ab1d4e6a4d0e4ea3e8c1fbb1a2a6b0b1a2c3d/2::,5:,:,:,,";
        for (token, expected) in [
            (
                "@ros2_lv/3/fe1bcc09/0/0/NN/%/%fleet/pioneer",
                0xd1c5_0192_b7bb_4a6d_a2ef_9394_3d2f_0345_u128,
            ),
            (topic, 0xa26f_96d2_4f5d_e8ec_b376_25c1_63e2_eedf),
        ] {
            assert_eq!(gid(token), expected.to_be_bytes());
        }
    }
}
