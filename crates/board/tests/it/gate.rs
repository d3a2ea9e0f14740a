//! R7: a command takes effect only while its writer holds a grant. `loom.rs` tries the interleavings,
//! `torture.rs` runs on the real machine.

use jde_board::{Access, Refused, Writer};

use crate::common::{COMMAND, float64, variable};

fn command(writer: &mut Writer, value: f64) -> Result<u64, Refused> {
    writer.loan().copy_from_slice(&value.to_ne_bytes());
    writer.publish(0, 0)
}

#[test]
fn r7_without_a_grant_no_command_takes_effect_and_all_are_counted() {
    let velocity = variable(&float64(), COMMAND);
    let mut goon = velocity.writer(1, "goon").unwrap();
    assert!(!velocity.has_grant(1));
    for _ in 0..20 {
        assert_eq!(command(&mut goon, 1.0), Err(Refused::NoAuthority));
    }
    let status = velocity.status(0);
    assert_eq!((status.sequence, status.refused), (0, 20));
    velocity.grant(1);
    assert!(velocity.has_grant(1));
    assert_eq!(
        command(&mut goon, 1.0),
        Ok(1),
        "the slots of refused commands are not lost"
    );
}

#[test]
fn r7_a_loan_from_before_the_withdrawal_is_refused_after_it() {
    let velocity = variable(&float64(), COMMAND);
    let mut goon = velocity.writer(1, "goon").unwrap();
    velocity.grant(1);
    goon.loan().fill(0);
    velocity.withdraw(1);
    assert_eq!(goon.publish(0, 0), Err(Refused::NoAuthority));
    assert_eq!(velocity.newest(), 0);
}

#[test]
fn r7_withdrawing_one_leaves_the_other_its_grant() {
    let velocity = variable(&float64(), COMMAND);
    let mut goon = velocity.writer(1, "goon").unwrap();
    let mut stop = velocity.writer(2, "stop").unwrap();
    velocity.grant(1);
    velocity.grant(2);
    assert_eq!(command(&mut goon, 1.0), Ok(1));
    velocity.withdraw(1);
    assert_eq!(command(&mut stop, 0.0), Ok(2));
    assert_eq!(command(&mut goon, 1.0), Err(Refused::NoAuthority));
    velocity.grant(1);
    assert_eq!(command(&mut goon, 1.0), Ok(3));
}

#[test]
fn r7_a_grant_goes_with_the_id_and_not_with_the_open_writer() {
    let velocity = variable(&float64(), COMMAND);
    velocity.grant(1);
    let mut goon = velocity.writer(1, "goon").unwrap();
    assert_eq!(command(&mut goon, 1.0), Ok(1), "granted before it was opened");
    drop(goon);
    let mut stranger = velocity.writer(3, "stranger").unwrap();
    assert_eq!(
        command(&mut stranger, 1.0),
        Err(Refused::NoAuthority),
        "a seat is not inherited"
    );
    let mut again = velocity.writer(1, "goon").unwrap();
    assert_eq!(command(&mut again, 1.0), Ok(2));
    velocity.withdraw(1);
    drop(again);
    let mut again = velocity.writer(1, "goon").unwrap();
    assert_eq!(command(&mut again, 1.0), Err(Refused::NoAuthority));
}

#[test]
fn r7_the_host_brakes_whoever_is_granted() {
    let velocity = variable(&float64(), COMMAND);
    let mut goon = velocity.writer(1, "goon").unwrap();
    velocity.grant(1);
    assert_eq!(command(&mut goon, 1.0), Ok(1));
    velocity.withdraw(1);
    assert_eq!(velocity.put(0, &0f64.to_ne_bytes(), 0, u64::MAX), Ok(2));
    let mut driver = velocity.reader("driver");
    assert_eq!(driver.latch().unwrap().bytes, 0f64.to_ne_bytes());
}

#[test]
fn modulations_and_exports_need_no_grant() {
    for access in [Access::Export, Access::Modulation] {
        let variable = variable(&float64(), access);
        let mut writer = variable.writer(1, "w").unwrap();
        assert_eq!(command(&mut writer, 1.0), Ok(1));
        variable.withdraw(1);
        assert_eq!(command(&mut writer, 1.0), Ok(2));
    }
}
