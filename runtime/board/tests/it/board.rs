//! Variables as the host and the tools use them.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use jde_board::{Access, Board, Error, Reader, Refused, Stamp, Variable, Writer};

use crate::common::{COMMAND, EXPORT, declaration, float64, twist, variable, word_array};

pub(crate) fn write(writer: &mut Writer, value: f64, time: u64) -> Result<u64, Refused> {
    writer.loan().copy_from_slice(&value.to_ne_bytes());
    writer.publish(time, time)
}

pub(crate) fn latch(reader: &mut Reader) -> Option<(f64, Stamp)> {
    let latched = reader.latch(0)?;
    Some((
        f64::from_ne_bytes(latched.bytes.try_into().unwrap()),
        latched.stamp,
    ))
}

/// Returns a numeric variable for each kind of cell and access. Writer 7 has the grant of the command.
pub(crate) fn numbers() -> [Arc<Variable>; 3] {
    let [export, modulation, command] =
        [EXPORT, Access::Modulation, COMMAND].map(|access| variable(&float64(), access));
    command.grant(7);
    [export, modulation, command]
}

#[test]
fn a_variable_is_found_by_owner_and_name() {
    let board = Board::new();
    let laser = board.declare(declaration("laser", &float64(), EXPORT)).unwrap();
    let pose = board.declare(declaration("pose", &float64(), EXPORT)).unwrap();
    assert!(Arc::ptr_eq(&board.find("pioneer.laser").unwrap(), &laser));
    assert!(Arc::ptr_eq(&board.get("pioneer.pose").unwrap(), &pose));
    assert!(board.find("laser").is_none());
    let names: Vec<_> = board
        .list()
        .map(|variable| variable.describe().full_name())
        .collect();
    assert_eq!(names, ["pioneer.laser", "pioneer.pose"]);
}

#[test]
fn an_unknown_name_is_refused_with_the_nearest() {
    let board = Board::new();
    board.declare(declaration("laser", &float64(), EXPORT)).unwrap();
    let near = board.get("pioneer.lasr").err().unwrap();
    assert_eq!(
        near.to_string(),
        "there is no variable `pioneer.lasr`; did you mean `pioneer.laser`?"
    );
    let far = board.get("goal").err().unwrap();
    assert_eq!(far.to_string(), "there is no variable `goal`");
}

#[test]
fn each_schema_is_a_name_space_without_duplicates() {
    let board = Board::new();
    board.declare(declaration("laser", &float64(), EXPORT)).unwrap();
    let duplicate = board.declare(declaration("laser", &twist(), EXPORT));
    assert_eq!(
        duplicate.err(),
        Some(Error::Duplicate("pioneer.laser".to_owned()))
    );
    let mut other = declaration("laser", &twist(), EXPORT);
    other.owner = "robot2".to_owned();
    board.declare(other).unwrap();
    assert_eq!(board.list().count(), 2);
}

#[test]
fn a_variable_without_an_owner_is_found_by_its_name_alone() {
    let mut topic = declaration("scan", &float64(), COMMAND);
    topic.owner.clear();
    let board = Board::new();
    board.declare(topic).unwrap();
    assert_eq!(board.find("scan").unwrap().describe().full_name(), "scan");
}

#[test]
fn an_invalid_declaration_is_refused_with_a_reason() {
    let refused = |change: fn(&mut jde_board::Declaration)| {
        let mut invalid = declaration("speed", &float64(), COMMAND);
        change(&mut invalid);
        Board::new().declare(invalid).err().unwrap().to_string()
    };
    assert_eq!(
        refused(|invalid| invalid.initial = Some(vec![0; 4])),
        "the initial value of `pioneer.speed` has 4 bytes; its type `std_msgs/msg/Float64` has 8"
    );
    assert_eq!(
        refused(|invalid| invalid.initial = Some(f64::NAN.to_ne_bytes().into())),
        "the initial value of `pioneer.speed` is not finite in `data`; give a finite number"
    );
    assert_eq!(
        refused(|invalid| invalid.name.clear()),
        "a variable of `pioneer` has no name"
    );
    assert_eq!(
        refused(|invalid| invalid.readers = 5000),
        "`pioneer.speed` is declared for 2 writers and 5000 readers; together at most 4093"
    );
}

#[test]
fn a_value_has_a_stamp() {
    for variable in numbers() {
        let mut writer = variable.writer(7, "driver").unwrap();
        let mut reader = variable.reader("view");
        assert_eq!(latch(&mut reader), None, "nothing was published");
        reader.release();
        assert_eq!(write(&mut writer, 1.5, 100), Ok(1));
        let (value, stamp) = latch(&mut reader).unwrap();
        assert_eq!(value, 1.5);
        assert_eq!((stamp.time, stamp.sequence, stamp.writer), (100, 1, 7));
        let expected_validity = if variable.describe().access == COMMAND {
            600
        } else {
            u64::MAX
        };
        assert_eq!(stamp.valid_until, expected_validity);
    }
}

#[test]
fn r8_a_latched_value_stays_until_it_is_released() {
    for variable in numbers() {
        let mut writer = variable.writer(7, "driver").unwrap();
        let mut reader = variable.reader("goon");
        write(&mut writer, 1.0, 1).unwrap();
        let first = reader.latch(0).unwrap();
        let (address, value) = (first.bytes.as_ptr(), first.bytes.to_vec());
        // Enough to reuse all slots of either cell.
        (2..40).for_each(|n| assert_eq!(write(&mut writer, f64::from(n), 2), Ok(n as u64)));
        let latched = reader.latch(0).unwrap();
        assert_eq!((latched.bytes.as_ptr(), latched.bytes), (address, &value[..]));
        assert_eq!(latched.stamp.sequence, 1);
        assert_eq!(reader.newest(), 39);
        reader.release();
        assert!(reader.latched().is_none());
        assert_eq!(latch(&mut reader).unwrap().0, 39.0);
    }
}

#[test]
fn r8_the_absence_of_a_value_lasts_until_the_release() {
    for variable in numbers() {
        let mut writer = variable.writer(7, "driver").unwrap();
        let mut reader = variable.reader("goon");
        assert_eq!(latch(&mut reader), None);
        write(&mut writer, 1.0, 1).unwrap();
        assert_eq!(
            latch(&mut reader),
            None,
            "a check and its iteration read the same"
        );
        assert!(reader.latched().is_none());
        reader.release();
        assert_eq!(latch(&mut reader).unwrap().0, 1.0);
    }
}

#[test]
fn an_initial_value_has_number_0_and_no_writer() {
    for access in [EXPORT, Access::Modulation, COMMAND] {
        let mut declared = declaration("gain", &float64(), access);
        declared.initial = Some(0.25f64.to_ne_bytes().into());
        let gain = Board::new().declare(declared).unwrap();
        let (value, stamp) = latch(&mut gain.reader("view")).unwrap();
        assert_eq!(value, 0.25);
        let expected = Stamp {
            time: 0,
            sequence: 0,
            writer: Stamp::NO_WRITER,
            valid_until: u64::MAX,
        };
        assert_eq!(stamp, expected);
        let status = gain.status(10);
        assert_eq!((status.sequence, status.age, status.last_writer), (0, None, None));
    }
}

#[test]
fn a_loaned_value_is_invisible_until_it_is_published() {
    for variable in numbers() {
        let mut writer = variable.writer(7, "driver").unwrap();
        let mut reader = variable.reader("view");
        assert_eq!(writer.publish(0, 0), Err(Refused::NothingLoaned));
        writer.loan().fill(1);
        assert!(reader.latch(0).is_none());
        reader.release();
        writer.discard();
        assert_eq!(writer.publish(0, 0), Err(Refused::NothingLoaned));
        assert_eq!(write(&mut writer, 2.0, 0), Ok(1));
        assert_eq!(
            writer.publish(0, 0),
            Err(Refused::NothingLoaned),
            "a loan is published once"
        );
        assert_eq!(latch(&mut reader).unwrap().0, 2.0);
    }
}

#[test]
fn values_are_aligned_for_any_type() {
    for value_type in [float64(), twist(), word_array(1000)] {
        for access in [EXPORT, Access::Modulation] {
            let variable = variable(&value_type, access);
            let mut writer = variable.writer(1, "w").unwrap();
            let loan = writer.loan();
            assert!(loan.as_ptr().cast::<u128>().is_aligned());
            loan.fill(0);
            writer.publish(0, 0).unwrap();
            // The third reader exceeds the declared two, so it copies.
            let mut readers = [0; 3].map(|_| variable.reader("r"));
            for reader in &mut readers {
                assert!(
                    reader
                        .latch(0)
                        .unwrap()
                        .bytes
                        .as_ptr()
                        .cast::<u128>()
                        .is_aligned()
                );
            }
        }
    }
}

#[test]
fn an_export_has_one_writer_at_a_time() {
    let laser = variable(&float64(), EXPORT);
    let first = laser.writer(1, "pioneer").unwrap();
    let refused = laser.writer(2, "player").err().unwrap();
    assert_eq!(
        refused.to_string(),
        "`pioneer.laser` allows 1 writer(s), and pioneer already writes it; `player` cannot"
    );
    drop(first);
    assert_eq!(laser.writer(2, "player").unwrap().id(), 2);
}

#[test]
fn r8_a_modulation_with_several_writers_has_the_value_of_the_last() {
    let target = variable(&float64(), Access::Modulation);
    let mut father = target.writer(1, "example").unwrap();
    let mut operator = target.writer(2, "operator").unwrap();
    assert!(target.writer(3, "third").is_err(), "declared for two");
    let mut reader = target.reader("goon");
    assert_eq!(write(&mut father, 1.0, 10), Ok(1));
    assert_eq!(write(&mut operator, 2.0, 20), Ok(2));
    assert_eq!(
        latch(&mut reader).map(|(value, stamp)| (value, stamp.writer)),
        Some((2.0, 2))
    );
    reader.release();
    assert_eq!(write(&mut father, 3.0, 30), Ok(3));
    assert_eq!(
        latch(&mut reader).map(|(value, stamp)| (value, stamp.writer)),
        Some((3.0, 1))
    );
}

#[test]
fn commands_and_modulations_that_are_not_finite_are_refused_and_counted() {
    let [export, modulation, command] = numbers();
    for variable in [modulation, command] {
        let mut writer = variable.writer(7, "goon").unwrap();
        assert_eq!(write(&mut writer, f64::NAN, 0), Err(Refused::NotFinite));
        assert_eq!(write(&mut writer, f64::INFINITY, 0), Err(Refused::NotFinite));
        assert_eq!(
            variable.put(0, &f64::NAN.to_ne_bytes(), 0, u64::MAX),
            Err(Refused::NotFinite)
        );
        let status = variable.status(0);
        assert_eq!((status.sequence, status.not_finite, status.refused), (0, 3, 0));
        assert_eq!(status.not_finite_at.as_deref(), Some("data"));
        assert_eq!(
            write(&mut writer, 1.0, 0),
            Ok(1),
            "the slots of refused values are not lost"
        );
    }
    let mut writer = export.writer(7, "laser").unwrap();
    assert_eq!(
        write(&mut writer, f64::INFINITY, 0),
        Ok(1),
        "infinity is a valid value of a sensor"
    );
}

#[test]
fn the_host_can_put_values_only_into_commands_and_modulations() {
    let [export, modulation, command] = numbers();
    let value = 1.0f64.to_ne_bytes();
    assert_eq!(export.put(0, &value, 5, 50), Err(Refused::NoAuthority));
    assert_eq!(modulation.put(0, &value[..4], 5, 50), Err(Refused::WrongSize));
    for variable in [modulation, command] {
        assert_eq!(variable.put(9, &value, 5, 50), Ok(1));
        let (value, stamp) = latch(&mut variable.reader("driver")).unwrap();
        assert_eq!((value, stamp.writer, stamp.valid_until), (1.0, 9, 50));
    }
}

#[test]
fn the_status_contains_the_users_and_the_rate() {
    let laser = variable(&float64(), EXPORT);
    let mut writer = laser.writer(4, "pioneer").unwrap();
    let reader = laser.reader("stop");
    let other = laser.reader("view");
    for n in 0..20 {
        write(&mut writer, 0.0, n * 100_000_000).unwrap();
    }
    let status = laser.status(2_000_000_000);
    assert_eq!((status.sequence, status.age), (20, Some(100_000_000)));
    assert!((status.rate_hz - 10.0).abs() < 1e-6, "{}", status.rate_hz);
    assert_eq!(status.last_writer, Some(4));
    assert_eq!(status.writers, ["pioneer"]);
    assert_eq!(status.readers, ["stop", "view"]);
    drop((reader, writer));
    let status = laser.status(2_000_000_000);
    assert_eq!(
        (status.writers.len(), status.readers),
        (0, vec!["view".to_owned()])
    );
    drop(other);
}

#[test]
fn readers_beyond_the_declared_number_read_copies() {
    let image = variable(&word_array(1000), EXPORT);
    let mut writer = image.writer(1, "camera").unwrap();
    let mut readers: Vec<_> = (0..10).map(|n| image.reader(&format!("r{n}"))).collect();
    for round in 1..=20u8 {
        writer.loan().fill(round);
        writer.publish(0, 0).unwrap();
        // One reader at a time latches a new value. All others keep their values.
        let reader = &mut readers[usize::from(round) % 10];
        reader.release();
        assert_eq!(reader.latch(0).unwrap().bytes[999], round);
    }
    let held: Vec<u8> = readers
        .iter()
        .map(|reader| reader.latched().unwrap().bytes[0])
        .collect();
    assert_eq!(held, [20, 11, 12, 13, 14, 15, 16, 17, 18, 19]);
}

#[test]
fn a_wait_ends_at_once_if_there_is_a_newer_value() {
    for variable in numbers() {
        let mut writer = variable.writer(7, "w").unwrap();
        write(&mut writer, 0.0, 0).unwrap();
        assert_eq!(variable.wait_newer(0, Duration::MAX), 1);
        assert_eq!(
            variable.wait_newer(1, Duration::ZERO),
            1,
            "a timeout of zero does not wait"
        );
    }
}

#[test]
fn a_wait_ends_after_its_timeout() {
    let laser = variable(&float64(), EXPORT);
    let start = std::time::Instant::now();
    assert_eq!(laser.wait_newer(0, Duration::from_millis(3)), 0);
    assert!(start.elapsed() >= Duration::from_millis(3));
}

#[test]
fn r12_watchers_are_called_after_each_publication_and_read_its_value() {
    for variable in numbers() {
        let mut writer = variable.writer(7, "w").unwrap();
        write(&mut writer, 0.0, 0).unwrap();
        let seen: [Arc<AtomicU64>; 2] = Default::default();
        let watches = seen.each_ref().map(|seen| {
            let (seen, watched) = (seen.clone(), Arc::downgrade(&variable));
            variable.watch(move || seen.store(watched.upgrade().unwrap().newest(), Ordering::Relaxed))
        });
        assert_eq!(seen[0].load(Ordering::Relaxed), 0, "nothing was published since");
        write(&mut writer, 0.0, 0).unwrap();
        assert_eq!(seen.each_ref().map(|seen| seen.load(Ordering::Relaxed)), [2, 2]);
        variable.put(0, &0f64.to_ne_bytes(), 0, 0).ok();
        assert_eq!(seen[0].load(Ordering::Relaxed), variable.newest());
        drop(watches);
        let last = variable.newest();
        write(&mut writer, 0.0, 0).unwrap();
        assert_eq!(
            seen.map(|seen| seen.load(Ordering::Relaxed)),
            [last, last],
            "dropped watches are not called"
        );
    }
}

#[test]
fn readers_get_no_value_between_a_retraction_and_the_next_value() {
    for export in [variable(&float64(), EXPORT), variable(&word_array(40), EXPORT)] {
        let mut writer = export.writer(1, "eye").unwrap();
        let mut reader = export.reader("low");
        let calls = Arc::new(AtomicU64::new(0));
        let counted = Arc::clone(&calls);
        let _watch = export.watch(move || {
            counted.fetch_add(1, Ordering::SeqCst);
        });
        writer.retract();
        assert_eq!(calls.load(Ordering::SeqCst), 0, "there is no value to retract");
        writer.loan();
        writer.publish(10, 10).unwrap();
        assert_eq!(reader.latch(0).unwrap().stamp.sequence, 1);
        writer.retract();
        assert_eq!(
            reader.latch(0).unwrap().stamp.sequence,
            1,
            "a reader keeps the value that it holds (R8)"
        );
        reader.release();
        assert!(reader.latch(0).is_none());
        assert!(export.status(20).ended);
        writer.retract();
        assert_eq!(calls.load(Ordering::SeqCst), 2, "a retraction is reported once");
        reader.release();
        writer.loan();
        writer.publish(30, 30).unwrap();
        assert_eq!(reader.latch(0).unwrap().stamp.sequence, 2);
        assert!(!export.status(30).ended);
    }
}

#[test]
fn modulations_and_commands_always_have_a_value() {
    for number in &numbers()[1..] {
        let mut writer = number.writer(7, "father").unwrap();
        write(&mut writer, 3.0, 5).unwrap();
        number.retract();
        assert_eq!(latch(&mut number.reader("child")).unwrap().0, 3.0);
    }
}

#[test]
fn a_time_in_the_future_is_replaced_by_the_time_of_publication() {
    for access in [EXPORT, Access::Modulation] {
        let scan = variable(&float64(), access);
        let mut writer = scan.writer(4, "pioneer").unwrap();
        writer.loan().copy_from_slice(&1.0_f64.to_ne_bytes());
        writer.publish(u64::MAX, 1_000).unwrap();
        assert_eq!(scan.reader("stop").latch(0).unwrap().stamp.time, 1_000);
        assert_eq!(scan.status(3_000).age, Some(2_000));
    }
}
