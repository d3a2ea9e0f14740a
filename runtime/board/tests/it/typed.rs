//! Variables as Rust values.

use jde_board::typed::{Plain, TypedReader, TypedWriter};
use jde_board::{Access, Refused};

use crate::common::{COMMAND, EXPORT, float64, twist, variable, word_array};

#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
struct Twist {
    linear: [f64; 3],
    angular: [f64; 3],
}

// SAFETY: six floats without a gap.
#[allow(unsafe_code, reason = "this is how a plain type is declared")]
unsafe impl Plain for Twist {}

const TURN: Twist = Twist {
    linear: [0.0; 3],
    angular: [0.0, 0.0, 0.5],
};

#[test]
fn a_structure_is_written_and_read() {
    for access in [EXPORT, Access::Modulation] {
        let velocity = variable(&twist(), access);
        let mut writer = TypedWriter::<Twist>::open(&velocity, 3, "vff").unwrap();
        let mut reader = TypedReader::<Twist>::open(&velocity, "driver").unwrap();
        assert!(reader.get(0).is_none());
        assert!(reader.borrow(0).is_none());
        assert_eq!(writer.write(TURN, 70, 70), Ok(1));
        let (value, stamp) = reader.get(0).unwrap();
        assert_eq!((value, stamp.time, stamp.writer), (TURN, 70, 3));
        assert_eq!(reader.borrow(0).unwrap().angular[2], 0.5);
    }
}

#[test]
fn get_always_returns_the_newest() {
    let number = variable(&float64(), Access::Modulation);
    let mut writer = TypedWriter::<f64>::open(&number, 1, "w").unwrap();
    let mut reader = TypedReader::<f64>::open(&number, "r").unwrap();
    for n in 1..=10 {
        writer.write(f64::from(n), 0, 0).unwrap();
        assert_eq!(reader.get(0).unwrap().0, f64::from(n));
    }
}

#[test]
fn a_borrowed_value_stays_while_others_are_published() {
    let image = variable(&word_array(1000), EXPORT);
    let mut writer = TypedWriter::<[u64; 1000]>::open(&image, 1, "camera").unwrap();
    let mut reader = TypedReader::<[u64; 1000]>::open(&image, "view").unwrap();
    writer.write([1; 1000], 0, 0).unwrap();
    let first = reader.borrow(0).unwrap();
    (2..20).for_each(|n| assert_eq!(writer.write([n; 1000], 0, 0), Ok(n)));
    assert_eq!((*first, first.stamp().sequence), ([1; 1000], 1));
    assert_eq!(reader.borrow(0).unwrap()[999], 19);
}

#[test]
fn a_loan_is_written_in_place_and_has_no_effect_if_dropped() {
    let image = variable(&word_array(1000), EXPORT);
    let mut writer = TypedWriter::<[u64; 1000]>::open(&image, 1, "camera").unwrap();
    let mut reader = TypedReader::<[u64; 1000]>::open(&image, "view").unwrap();
    let mut loan = writer.loan();
    loan.fill(5);
    drop(loan);
    assert!(reader.get(0).is_none());
    let mut loan = writer.loan();
    loan.fill(6);
    assert_eq!(loan[3], 6);
    assert_eq!(loan.publish(9, 9), Ok(1));
    assert_eq!(reader.get(0).unwrap().0, [6; 1000]);
}

#[test]
fn r7_a_typed_command_needs_a_grant() {
    let velocity = variable(&twist(), COMMAND);
    let mut writer = TypedWriter::<Twist>::open(&velocity, 3, "vff").unwrap();
    assert_eq!(writer.write(TURN, 0, 0), Err(Refused::NoAuthority));
    velocity.grant(3);
    assert_eq!(writer.write(TURN, 0, 0), Ok(1));
}

#[test]
fn a_type_that_does_not_fit_is_refused_with_a_reason() {
    #[derive(Clone, Copy)]
    #[repr(C, align(32))]
    struct Wide([u64; 4]);
    // SAFETY: four words without a gap.
    #[allow(unsafe_code, reason = "this is how a plain type is declared")]
    unsafe impl Plain for Wide {}

    let number = variable(&float64(), EXPORT);
    assert_eq!(
        TypedReader::<f32>::open(&number, "r").err().unwrap().to_string(),
        "`pioneer.laser` is a `std_msgs/msg/Float64` of 8 bytes, and `f32` has 4; open it with the type it was declared with"
    );
    assert!(TypedWriter::<[u8; 9]>::open(&number, 1, "w").is_err());
    assert!(
        TypedReader::<u64>::open(&number, "r").is_ok(),
        "only size and alignment are checked"
    );
    let four = variable(&word_array(4), EXPORT);
    let wide = TypedReader::<Wide>::open(&four, "r").err().unwrap().to_string();
    assert!(wide.contains("needs alignment 32"), "{wide}");
    assert_eq!(four.status(0).readers.len(), 0, "a refused reader is not listed");
}
