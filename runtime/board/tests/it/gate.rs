//! R7: a command takes effect only while its writer holds a grant. `loom.rs` checks the interleavings,
//! `torture.rs` runs on real threads.

use jde_board::{Access, Refused, Writer};

use crate::common::{COMMAND, EXPORT, float64, variable};

fn command(writer: &mut Writer, value: f64) -> Result<u64, Refused> {
    writer.loan().copy_from_slice(&value.to_ne_bytes());
    writer.publish(0, 0)
}

#[test]
fn r7_commands_without_a_grant_are_refused_and_counted() {
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
fn r7_a_withdrawal_does_not_affect_the_grants_of_others() {
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
fn r7_a_grant_belongs_to_the_id_and_not_to_the_open_writer() {
    let velocity = variable(&float64(), COMMAND);
    velocity.grant(1);
    let mut goon = velocity.writer(1, "goon").unwrap();
    assert_eq!(
        command(&mut goon, 1.0),
        Ok(1),
        "granted before the writer was opened"
    );
    drop(goon);
    let mut other = velocity.writer(3, "other").unwrap();
    assert_eq!(
        command(&mut other, 1.0),
        Err(Refused::NoAuthority),
        "a grant does not pass to another writer"
    );
    let mut reopened = velocity.writer(1, "goon").unwrap();
    assert_eq!(command(&mut reopened, 1.0), Ok(2));
    velocity.withdraw(1);
    drop(reopened);
    let mut reopened = velocity.writer(1, "goon").unwrap();
    assert_eq!(command(&mut reopened, 1.0), Err(Refused::NoAuthority));
}

#[test]
fn r7_the_host_can_brake_regardless_of_grants() {
    let velocity = variable(&float64(), COMMAND);
    let mut goon = velocity.writer(1, "goon").unwrap();
    velocity.grant(1);
    assert_eq!(command(&mut goon, 1.0), Ok(1));
    velocity.withdraw(1);
    assert_eq!(velocity.put(0, &0f64.to_ne_bytes(), 0, u64::MAX), Ok(2));
    let mut driver = velocity.reader("driver");
    assert_eq!(driver.latch(0).unwrap().bytes, 0f64.to_ne_bytes());
}

#[test]
fn modulations_and_exports_need_no_grant() {
    for access in [EXPORT, Access::Modulation] {
        let variable = variable(&float64(), access);
        let mut writer = variable.writer(1, "w").unwrap();
        assert_eq!(command(&mut writer, 1.0), Ok(1));
        variable.withdraw(1);
        assert_eq!(command(&mut writer, 1.0), Ok(2));
    }
}
