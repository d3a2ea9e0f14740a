//! Numbers as fields, and on their own as values: a single `f64` is a `std_msgs/msg/Float64`, an array of
//! them a `jde_msgs/msg/Float64Array`.

#![allow(unsafe_code)]

use core::ffi::CStr;

use jde_abi::raw;

use crate::part::{FieldLayout, Part, field};
use crate::value::{Value, structure};
use crate::{Flag, Text};

macro_rules! single_value {
    ($ty:ty, [$($generic:tt)*], $name:expr, $doc:expr) => {
        // SAFETY: its one field covers it, and every byte pattern is valid because it is a `Part`.
        unsafe impl<$($generic)*> Value for $ty {
            const TYPE: &'static raw::Type = &structure::<Self>(
                $name,
                $doc,
                &[field::<Self>(0, c"data", c"The value.", c"")],
            );
        }
    };
}

macro_rules! scalars {
    ($($ty:ty, $kind:ident, $name:literal;)*) => { $(
        // SAFETY: every byte pattern is a valid number.
        unsafe impl Part for $ty {
            const SHAPE: FieldLayout = FieldLayout::scalar(raw::$kind);
        }
        single_value!($ty, [], name(concat!("std_msgs/msg/", $name, "\0")), c"A number by itself.");
        single_value!([$ty; N], [const N: usize], name(concat!("jde_msgs/msg/", $name, "Array\0")), c"A fixed number of numbers.");
    )* };
}

const fn name(text: &'static str) -> &'static CStr {
    match CStr::from_bytes_with_nul(text.as_bytes()) {
        Ok(name) => name,
        Err(_) => panic!("a name ends with its only NUL"),
    }
}

scalars! {
    u8, U8, "UInt8";
    u16, U16, "UInt16";
    u32, U32, "UInt32";
    u64, U64, "UInt64";
    i8, I8, "Int8";
    i16, I16, "Int16";
    i32, I32, "Int32";
    i64, I64, "Int64";
    f32, F32, "Float32";
    f64, F64, "Float64";
}

single_value!(Flag, [], c"std_msgs/msg/Bool", c"True or false by itself.");
single_value!(Text<N>, [const N: usize], c"std_msgs/msg/String", c"A text by itself.");
