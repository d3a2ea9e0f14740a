//! What must hold of the readers of messages for any bytes. The fuzz target `link` runs this too.

use jde_link::decode;
use jde_records::RecordKind;

/// Reads bytes as every message that the other end of a link can send. Whatever passes can be walked through.
pub(crate) fn messages(data: &[u8]) {
    let _ = (
        decode::about(data),
        decode::operate_reply(data),
        decode::refusal(data),
        decode::request(data),
    );
    if let Ok(snapshot) = decode::snapshot(data) {
        for schema in 0..snapshot.schemas.len() {
            let fathers = std::iter::successors(Some(schema), |place| snapshot.schemas[*place].father);
            assert!(fathers.count() <= snapshot.schemas.len());
        }
        for group in &snapshot.groups {
            let _ = snapshot.winner_name(group);
            assert!(
                group
                    .members
                    .iter()
                    .all(|member| snapshot.schemas[*member].father == group.father)
            );
        }
    }
    if let Ok(all) = decode::schemas(data) {
        let is_there = |name: &String| all.schemas.iter().any(|schema| schema.name == *name);
        let fathers = all.schemas.iter().filter_map(|schema| schema.father.as_ref());
        assert!(
            fathers
                .chain(all.groups.iter().flat_map(|group| &group.members))
                .all(is_there)
        );
    }
    for variable in decode::variables(data).unwrap_or_default() {
        let _ = variable.value_type();
    }
    for kind in RecordKind::ALL {
        if let Ok(record) = decode::record(kind, data) {
            let _ = record.time();
        }
        let _ = decode::records(kind, data);
    }
}
