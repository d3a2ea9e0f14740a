//! Variables as Rust values, for tests, tools and examples. It checks size and alignment, but not the
//! meaning of fields.

#![allow(unsafe_code, reason = "bytes and plain values are views of each other")]

use std::marker::PhantomData;
use std::mem::ManuallyDrop;
use std::ops::{Deref, DerefMut};
use std::ptr::NonNull;
use std::sync::Arc;

use crate::{Error, Nanos, Reader, Refused, Stamp, Variable, Writer};

/// The strictest alignment that a value may need. Loaned and latched bytes have a stricter one.
const MAX_ALIGN: usize = 16;

/// Plain data.
///
/// # Safety
/// Every bit pattern is a value, and there is no padding.
pub unsafe trait Plain: Copy + Send + Sync + 'static {}

macro_rules! plain {
    ($($number:ty)*) => { $(
        // SAFETY: numbers have no padding and no invalid bit patterns.
        unsafe impl Plain for $number {}
    )* };
}
plain!(u8 u16 u32 u64 u128 i8 i16 i32 i64 i128 f32 f64);

// SAFETY: an array consists of its elements, without gaps.
unsafe impl<T: Plain, const N: usize> Plain for [T; N] {}

/// Writes a variable as values of `T`.
pub struct TypedWriter<T> {
    writer: Writer,
    value: PhantomData<fn(T)>,
}

/// Reads a variable as values of `T`.
pub struct TypedReader<T> {
    reader: Reader,
    value: PhantomData<fn() -> T>,
}

/// A buffer for the next value. A drop without publishing discards it.
pub struct LoanMut<'a, T: Plain> {
    writer: &'a mut Writer,
    /// Points into the writer's loan, which does not move until a publish or a discard.
    value: NonNull<T>,
}

/// A value that is read in place and does not change.
pub struct Ref<'a, T> {
    value: &'a T,
    stamp: Stamp,
}

impl<T: Plain> TypedWriter<T> {
    /// Opens a variable for writing.
    ///
    /// # Errors
    /// As [`Variable::writer`], and if `T` has another size or an alignment above 16.
    pub fn open(variable: &Arc<Variable>, id: u32, name: &str) -> Result<Self, Error> {
        check_type::<T>(variable)?;
        Ok(Self {
            writer: variable.writer(id, name)?,
            value: PhantomData,
        })
    }

    /// Returns a buffer for the next value, with arbitrary contents.
    pub fn loan(&mut self) -> LoanMut<'_, T> {
        let value = NonNull::from(self.writer.loan()).cast();
        LoanMut {
            writer: &mut self.writer,
            value,
        }
    }

    /// Publishes a value.
    ///
    /// # Errors
    /// As [`Writer::publish`].
    pub fn write(&mut self, value: T, time: Nanos, now: Nanos) -> Result<u64, Refused> {
        let mut loan = self.loan();
        *loan = value;
        loan.publish(time, now)
    }
}

impl<T: Plain> TypedReader<T> {
    /// Opens a variable for reading.
    ///
    /// # Errors
    /// `T` has another size or an alignment above 16.
    pub fn open(variable: &Arc<Variable>, name: &str) -> Result<Self, Error> {
        check_type::<T>(variable)?;
        Ok(Self {
            reader: variable.reader(name),
            value: PhantomData,
        })
    }

    /// Returns a copy of the newest value; `None` if there is none that is valid at `now`.
    #[inline]
    pub fn get(&mut self, now: Nanos) -> Option<(T, Stamp)> {
        let borrowed = self.borrow(now)?;
        Some((*borrowed, borrowed.stamp))
    }

    /// Returns the newest value in place; `None` if there is none that is valid at `now`.
    #[inline]
    pub fn borrow(&mut self, now: Nanos) -> Option<Ref<'_, T>> {
        let latched = self.reader.latch_newest(now)?;
        // SAFETY: size and alignment were checked by `open`, and any bit pattern is a `T`.
        let value = unsafe { &*latched.bytes.as_ptr().cast::<T>() };
        Some(Ref {
            value,
            stamp: latched.stamp,
        })
    }
}

impl<T: Plain> LoanMut<'_, T> {
    /// Publishes the value.
    ///
    /// # Errors
    /// As [`Writer::publish`].
    pub fn publish(self, time: Nanos, now: Nanos) -> Result<u64, Refused> {
        // After the publish nothing is loaned, so there is nothing to discard.
        let mut loan = ManuallyDrop::new(self);
        loan.writer.publish(time, now)
    }
}

impl<T: Plain> Deref for LoanMut<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        // SAFETY: as in `deref_mut`.
        unsafe { self.value.as_ref() }
    }
}

impl<T: Plain> DerefMut for LoanMut<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        // SAFETY: size and alignment were checked by `open`, any bit pattern is a `T`, and the writer is
        // borrowed for as long.
        unsafe { self.value.as_mut() }
    }
}

impl<T: Plain> Drop for LoanMut<'_, T> {
    fn drop(&mut self) {
        self.writer.discard();
    }
}

impl<T> Ref<'_, T> {
    /// Returns its time, number and writer.
    #[must_use]
    pub fn stamp(&self) -> Stamp {
        self.stamp
    }
}

impl<T> Deref for Ref<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.value
    }
}

fn check_type<T: Plain>(variable: &Variable) -> Result<(), Error> {
    let declaration = variable.describe();
    let rust = std::any::type_name::<T>();
    if size_of::<T>() != declaration.value_type.bytes {
        return Err(Error::TypeSize {
            variable: declaration.full_name(),
            value_type: declaration.value_type.name.clone(),
            rust,
            expected: declaration.value_type.bytes,
            got: size_of::<T>(),
        });
    }
    if align_of::<T>() > MAX_ALIGN {
        return Err(Error::TypeAlign {
            variable: declaration.full_name(),
            rust,
            align: align_of::<T>(),
        });
    }
    Ok(())
}
