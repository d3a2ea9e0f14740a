//! The fields of records, in the order of their definitions. One list serves both directions.

use jde_core::{Case, State};
use jde_records::wire::{EventMessage, StateMessage, state_name, state_named};
use jde_records::{CandidateRecord, DecidedBy, Decision, RefusedCandidate};
use jde_ros::cdr::{Error, Reader, Writer};

/// A message that is being read or written.
pub(super) enum Cdr<'a, 'b> {
    Read(&'a mut Reader<'b>),
    Write(&'a mut Writer<'b>),
}

impl Cdr<'_, '_> {
    /// Whether a message that is read has no more fields.
    fn is_at_end(&self) -> bool {
        matches!(self, Self::Read(reader) if reader.is_at_end())
    }
}

/// A part of a message.
pub(super) trait Fields {
    /// Replaces the fields by those of a message, or writes them to one. Only reading fails.
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error>;
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Fields for $number {
            fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
                match cdr {
                    Cdr::Read(reader) => *self = Self::from_le_bytes(reader.number(stringify!($number))?),
                    Cdr::Write(writer) => writer.number(self.to_le_bytes()),
                }
                Ok(())
            }
        }
    )*};
}

numbers!(u8, i32, u32, u64, f64);

impl Fields for bool {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        let mut byte = u8::from(*self);
        byte.fields(cdr)?;
        *self = byte != 0;
        Ok(())
    }
}

impl Fields for String {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        match cdr {
            Cdr::Read(reader) => reader.text("string")?.clone_into(self),
            Cdr::Write(writer) => writer.text(self.as_bytes()),
        }
        Ok(())
    }
}

pub(super) fn no_name(field: &str, name: String) -> Error {
    let field = field.to_owned();
    Error::Name { field, name }
}

/// A name. None is written as an empty text.
impl Fields for Option<String> {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        let mut name = self.take().unwrap_or_default();
        name.fields(cdr)?;
        *self = Some(name).filter(|name| !name.is_empty());
        Ok(())
    }
}

/// A number that is finite. None is written as NaN.
impl Fields for Option<f64> {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        let mut number = self.unwrap_or(f64::NAN);
        number.fields(cdr)?;
        *self = Some(number).filter(|number| number.is_finite());
        Ok(())
    }
}

impl Fields for [f64; 3] {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        self.iter_mut().try_for_each(|number| number.fields(cdr))
    }
}

impl<T: Fields + Default> Fields for Vec<T> {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        match cdr {
            Cdr::Read(reader) => {
                let count = reader.length("sequence")?;
                self.clear();
                // The message may state any number of elements. The first one beyond its end is an error.
                for _ in 0..count {
                    let mut element = T::default();
                    element.fields(cdr)?;
                    self.push(element);
                }
                Ok(())
            }
            Cdr::Write(writer) => {
                writer.length(self.len());
                self.iter_mut().try_for_each(|element| element.fields(cdr))
            }
        }
    }
}

/// A time, s. It is written as `builtin_interfaces/Time`.
fn stamp(time_s: &mut f64, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
    let ns = (*time_s * 1e9).round() as u64;
    let mut seconds = i32::try_from(ns / 1_000_000_000).unwrap_or(i32::MAX);
    let mut rest = (ns % 1_000_000_000) as u32;
    seconds.fields(cdr)?;
    rest.fields(cdr)?;
    let ns = i64::from(seconds) * 1_000_000_000 + i64::from(rest);
    *time_s = ns as f64 / 1e9;
    Ok(())
}

impl Fields for Decision {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        stamp(&mut self.time_s, cdr)?;
        self.number.fields(cdr)?;
        self.group.fields(cdr)?;
        self.case.fields(cdr)?;
        self.candidates.fields(cdr)?;
        self.before.fields(cdr)?;
        self.choice.fields(cdr)?;
        self.decider.fields(cdr)?;
        self.reason.fields(cdr)?;
        self.cause.fields(cdr)?;
        self.changed.fields(cdr)?;
        // Seconds in the message, whole nanoseconds in any case.
        let mut takeover = self.takeover_us.map(|us| us / 1e6);
        takeover.fields(cdr)?;
        self.takeover_us = takeover.map(|seconds| (seconds * 1e9).round() / 1e3);
        if cdr.is_at_end() {
            // Messages of earlier versions end before it.
            return Ok(());
        }
        self.refused.fields(cdr)
    }
}

impl Fields for RefusedCandidate {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        self.name.fields(cdr)?;
        self.reason.fields(cdr)?;
        self.left_s.fields(cdr)
    }
}

impl Fields for CandidateRecord {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        self.name.fields(cdr)?;
        self.state.fields(cdr)?;
        self.ready.fields(cdr)?;
        self.urgency.fields(cdr)
    }
}

impl Fields for StateMessage {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        stamp(&mut self.time_s, cdr)?;
        self.schema.fields(cdr)?;
        self.from.fields(cdr)?;
        self.to.fields(cdr)
    }
}

/// The event itself, as JSON. Messages of earlier versions end before it.
impl Fields for Option<serde_json::Value> {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        if cdr.is_at_end() {
            return Ok(());
        }
        let mut text = self.as_ref().map(ToString::to_string).unwrap_or_default();
        text.fields(cdr)?;
        *self = serde_json::from_str(&text).ok();
        Ok(())
    }
}

impl Fields for Case {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        let mut name = self.name().to_owned();
        name.fields(cdr)?;
        *self = Self::named(&name).ok_or_else(|| no_name("case", name))?;
        Ok(())
    }
}

impl Fields for State {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        let mut name = state_name(*self);
        name.fields(cdr)?;
        *self = state_named(&name).map_err(|_| no_name("state", name))?;
        Ok(())
    }
}

impl Fields for DecidedBy {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        let mut name = self.name().to_owned();
        name.fields(cdr)?;
        *self = Self::from(name);
        Ok(())
    }
}

impl Fields for EventMessage {
    fn fields(&mut self, cdr: &mut Cdr<'_, '_>) -> Result<(), Error> {
        stamp(&mut self.time_s, cdr)?;
        self.kind.fields(cdr)?;
        self.schema.fields(cdr)?;
        self.by.fields(cdr)?;
        self.text.fields(cdr)?;
        self.touched.fields(cdr)?;
        self.data.fields(cdr)
    }
}
