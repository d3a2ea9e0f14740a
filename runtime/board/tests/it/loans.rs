//! Loans that are detached from their writer.

use jde_board::{Access, Refused};

use crate::board::{latch, numbers, write};
use crate::common::{EXPORT, float64, variable};

#[test]
fn a_detached_loan_is_not_reused_until_it_is_returned() {
    for variable in numbers() {
        let mut writer = variable.writer(7, "writer").unwrap();
        let detached_bytes = writer.loan();
        detached_bytes.copy_from_slice(&1.0_f64.to_ne_bytes());
        let detached_address = detached_bytes.as_mut_ptr();
        let detached = writer.detach_loan().unwrap().expect("a loan");
        assert_eq!(detached.bytes(), 8);
        assert_eq!(writer.publish(1, 1), Err(Refused::NothingLoaned));
        let mut reader = variable.reader("reader");
        for sequence in 1..20 {
            assert_ne!(
                writer.loan().as_mut_ptr(),
                detached_address,
                "the detached buffer is not loaned again"
            );
            write(&mut writer, sequence as f64, sequence).unwrap();
            reader.release();
            assert_eq!(latch(&mut reader).unwrap().0, sequence as f64);
        }
        assert!(writer.detach_loan().unwrap().is_none(), "nothing is loaned");
        drop(detached);
        let addresses: Vec<_> = (0..20)
            .map(|time| {
                let address = writer.loan().as_mut_ptr();
                write(&mut writer, 0.0, time).unwrap();
                address
            })
            .collect();
        let in_slot = variable.describe().access != EXPORT;
        assert_eq!(
            addresses.contains(&detached_address),
            in_slot,
            "a slot returns to its cell"
        );
    }
}

#[test]
fn at_most_as_many_loans_are_detached_as_readers_may_hold_slots() {
    let modulation = variable(&float64(), Access::Modulation);
    let mut writer = modulation.writer(7, "writer").unwrap();
    let mut detached = Vec::new();
    for _ in 0..modulation.describe().readers {
        writer.loan();
        detached.extend(writer.detach_loan().unwrap());
    }
    writer.loan();
    let error = writer
        .detach_loan()
        .err()
        .expect("every slot is in use")
        .to_string();
    assert!(error.starts_with("all "), "{error}");
    write(&mut writer, 1.0, 1).expect("the loan is unchanged");
    detached.pop();
    writer.loan();
    assert!(writer.detach_loan().is_ok_and(|detached| detached.is_some()));
}
