//! What holds for the log that any bytes are: nothing panics, time goes on and ends, and what is played fits its types.

use core::time::Duration;

use crate::log::LogFile;

/// Most seconds of a record: those of a pause.
const MAX_PAUSE_S: u64 = 60;

/// Reads bytes as a log.
pub(crate) fn log(data: &[u8]) {
    let interval = Duration::from_millis(200);
    let Ok(log) = LogFile::of(data, None, "fuzz.log", interval) else {
        return;
    };
    let records = log.records();
    assert!(records.is_sorted_by_key(|record| record.time));
    assert!(log.duration().as_secs() <= MAX_PAUSE_S * records.len() as u64);
    let scans = records.iter().filter_map(|record| record.scan.as_ref());
    for scan in scans.clone() {
        assert!((1..=1088).contains(&scan.ranges.len()));
        assert!(scan.angle_min.is_finite() && scan.angle_increment > 0.0 && scan.angle_increment < 7.0);
        assert!(scan.reach > 0.0 && scan.ranges.iter().all(|range| range.is_nan() || *range >= 0.0));
    }
    assert_eq!(scans.count(), log.scans());
    for next in 0..=records.len() {
        let _ = log.pose_between(next, log.duration() / 2);
    }
    assert!(log.notes().len() < 40 && log.notes().iter().all(|note| !note.contains(char::is_control)));
    assert!(log.mount().x.hypot(log.mount().y) <= 10.0 && log.no_return().is_none_or(|range| range > 1.0));
}
