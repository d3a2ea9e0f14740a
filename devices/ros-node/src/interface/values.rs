//! Values of interfaces: JSON to messages in CDR, and back. A float that is not finite is `null` in JSON, and `null` is NaN.

use jde_abi::describe::Scalar;
use jde_ros::cdr::{self, Reader, Writer};
use serde_json::{Map, Number, Value};

use super::{Count, Interfaces, Kind, Member};

/// A value that does not fit its interface.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ValueError {
    /// There is no interface of that name.
    #[error("there is no interface `{0}`")]
    Unknown(String),
    /// A field has another type.
    #[error("`{field}`: {value} is no {expected}")]
    Kind {
        /// The name of the field.
        field: String,
        /// Its value.
        value: String,
        /// What it is in the interface.
        expected: &'static str,
    },
    /// The interface does not have this field.
    #[error("`{interface}` has no field `{field}`")]
    Field {
        /// The name of the interface.
        interface: String,
        /// The name of the field.
        field: String,
    },
    /// The bytes are no message of this interface.
    #[error(transparent)]
    Message(#[from] cdr::Error),
}

impl Interfaces {
    /// Returns a value as a message. Fields that it does not have are zero or empty.
    ///
    /// # Errors
    /// [`ValueError`].
    pub fn encode(&self, name: &str, value: &Value) -> Result<Vec<u8>, ValueError> {
        let mut message = Vec::new();
        self.write(name, "", value, &mut Writer::new(&mut message))?;
        Ok(message)
    }

    /// Returns the value of a message.
    ///
    /// # Errors
    /// [`ValueError`]. For any bytes, the memory is proportional to their number.
    pub fn decode(&self, name: &str, message: &[u8]) -> Result<Value, ValueError> {
        let mut reader = Reader::new(message)?;
        let value = self.read(name, &mut reader)?;
        reader.finish()?;
        Ok(value)
    }

    fn members(&self, name: &str) -> Result<&[Member], ValueError> {
        let members = self.0.get(name).map(Vec::as_slice);
        members.ok_or_else(|| ValueError::Unknown(name.to_owned()))
    }

    fn write(
        &self,
        name: &str,
        field: &str,
        value: &Value,
        writer: &mut Writer<'_>,
    ) -> Result<(), ValueError> {
        let members = self.members(name)?;
        let empty = Map::new();
        let object = match value {
            Value::Null => &empty,
            value => value.as_object().ok_or_else(|| kind(field, value, "structure"))?,
        };
        let is_member = |key: &&String| members.iter().any(|member| member.name == **key);
        if let Some(key) = object.keys().find(|key| !is_member(key)) {
            return Err(ValueError::Field {
                interface: name.to_owned(),
                field: key.clone(),
            });
        }
        if members.is_empty() {
            writer.bytes(&[0]);
        }
        for member in members {
            self.write_member(member, object.get(&member.name), writer)?;
        }
        Ok(())
    }

    fn write_member(
        &self,
        member: &Member,
        stated: Option<&Value>,
        writer: &mut Writer<'_>,
    ) -> Result<(), ValueError> {
        if matches!(member.count, Count::One) {
            return self.write_element(member, stated, writer);
        }
        let value = stated.unwrap_or(&Value::Null);
        let elements = match value {
            Value::Null => &[][..],
            value => value
                .as_array()
                .ok_or_else(|| kind(&member.name, value, "list"))?,
        };
        match member.count {
            Count::Array(count) if elements.is_empty() => {
                return (0..count).try_for_each(|_| self.write_element(member, None, writer));
            }
            Count::Array(count) if elements.len() != count => {
                return Err(kind(&member.name, value, "list of this length"));
            }
            Count::Sequence(bound) if bound > 0 && elements.len() > bound => {
                return Err(kind(&member.name, value, "list of this length"));
            }
            Count::Sequence(_) => writer.length(elements.len()),
            Count::One | Count::Array(_) => {}
        }
        elements
            .iter()
            .try_for_each(|element| self.write_element(member, Some(element), writer))
    }

    fn write_element(
        &self,
        member: &Member,
        stated: Option<&Value>,
        writer: &mut Writer<'_>,
    ) -> Result<(), ValueError> {
        let value = stated.unwrap_or(&Value::Null);
        match &member.kind {
            Kind::Message(name) => self.write(name, &member.name, value, writer),
            Kind::Text(_) => {
                let text = match value {
                    Value::Null => "",
                    value => value.as_str().ok_or_else(|| kind(&member.name, value, "text"))?,
                };
                writer.text(text.as_bytes());
                Ok(())
            }
            Kind::Scalar(scalar, _) => {
                let bytes = scalar_bytes(*scalar, stated)
                    .ok_or_else(|| kind(&member.name, value, scalar.ros_name()))?;
                writer.align(bytes.len());
                writer.bytes(&bytes);
                Ok(())
            }
        }
    }

    fn read(&self, name: &str, reader: &mut Reader<'_>) -> Result<Value, ValueError> {
        let members = self.members(name)?;
        if members.is_empty() {
            reader.take(1, 1, name)?;
        }
        let mut object = Map::new();
        for member in members {
            let value = match member.count {
                Count::One => self.read_element(member, reader)?,
                Count::Array(count) => self.read_elements(member, count, reader)?,
                Count::Sequence(_) => {
                    let count = reader.length(&member.name)?;
                    self.read_elements(member, count, reader)?
                }
            };
            object.insert(member.name.clone(), value);
        }
        Ok(Value::Object(object))
    }

    fn read_elements(
        &self,
        member: &Member,
        count: usize,
        reader: &mut Reader<'_>,
    ) -> Result<Value, ValueError> {
        // Every element has at least one byte, so a wrong count ends with the bytes.
        (0..count).map(|_| self.read_element(member, reader)).collect()
    }

    fn read_element(&self, member: &Member, reader: &mut Reader<'_>) -> Result<Value, ValueError> {
        match &member.kind {
            Kind::Message(name) => self.read(name, reader),
            Kind::Text(_) => Ok(Value::from(reader.text(&member.name)?)),
            Kind::Scalar(scalar, _) => {
                let size = scalar.bytes();
                let bytes = reader.take(size, size, &member.name)?;
                Ok(scalar_value(*scalar, bytes))
            }
        }
    }
}

fn kind(field: &str, value: &Value, expected: &'static str) -> ValueError {
    ValueError::Kind {
        field: field.to_owned(),
        value: value.to_string(),
        expected,
    }
}

/// Returns the bytes of a number, little endian, which is 0 if none is stated; `None` if the value is none of that type.
fn scalar_bytes(scalar: Scalar, stated: Option<&Value>) -> Option<Vec<u8>> {
    /// The value as an integer of that type.
    fn integer<T: TryFrom<i64> + TryFrom<u64> + Default>(value: &Value) -> Option<T> {
        match (value.as_i64(), value.as_u64()) {
            (_, Some(number)) => number.try_into().ok(),
            (Some(number), None) => number.try_into().ok(),
            (None, None) => value.is_null().then(T::default),
        }
    }
    let value = stated.unwrap_or(&Value::Null);
    let float = || match stated {
        None => Some(0.0),
        Some(Value::Null) => Some(f64::NAN),
        Some(value) => value.as_f64(),
    };
    Some(match scalar {
        Scalar::Bool => vec![u8::from(
            value.as_bool().or_else(|| value.is_null().then_some(false))?,
        )],
        Scalar::U8 => vec![integer::<u8>(value)?],
        Scalar::I8 => integer::<i8>(value)?.to_le_bytes().to_vec(),
        Scalar::U16 => integer::<u16>(value)?.to_le_bytes().to_vec(),
        Scalar::I16 => integer::<i16>(value)?.to_le_bytes().to_vec(),
        Scalar::U32 => integer::<u32>(value)?.to_le_bytes().to_vec(),
        Scalar::I32 => integer::<i32>(value)?.to_le_bytes().to_vec(),
        Scalar::U64 => integer::<u64>(value)?.to_le_bytes().to_vec(),
        Scalar::I64 => integer::<i64>(value)?.to_le_bytes().to_vec(),
        Scalar::F32 => (float()? as f32).to_le_bytes().to_vec(),
        Scalar::F64 => float()?.to_le_bytes().to_vec(),
    })
}

/// Returns the number of these bytes, little endian.
fn scalar_value(scalar: Scalar, bytes: &[u8]) -> Value {
    let mut wide = [0; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    let raw = u64::from_le_bytes(wide);
    let signed = || (raw << (64 - 8 * bytes.len())).cast_signed() >> (64 - 8 * bytes.len());
    let float = |number: f64| Number::from_f64(number).map_or(Value::Null, Value::Number);
    match scalar {
        Scalar::Bool => Value::from(raw != 0),
        Scalar::U8 | Scalar::U16 | Scalar::U32 | Scalar::U64 => Value::from(raw),
        Scalar::I8 | Scalar::I16 | Scalar::I32 | Scalar::I64 => Value::from(signed()),
        Scalar::F32 => float(f64::from(f32::from_bits(raw as u32))),
        Scalar::F64 => float(f64::from_bits(raw)),
    }
}
