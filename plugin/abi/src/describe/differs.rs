//! The difference between two types of the same name, for the message about two plugins that define it
//! differently.

use super::{Field, FieldKind, Form, Type};

impl Type {
    /// Returns the first difference between the layouts, such as "field `speed` is float64 here and float32
    /// there". "here" is `self` and "there" is `other`. `None` if they are equal.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<String> {
        self.difference_in("", other)
    }

    fn difference_in(&self, prefix: &str, other: &Self) -> Option<String> {
        for (own, others) in self.fields.iter().zip(&other.fields) {
            if own.name != others.name {
                return Some(format!(
                    "field `{prefix}{}` here is `{prefix}{}` there",
                    own.name, others.name
                ));
            }
            let (here, there) = (own.shape(), others.shape());
            if here != there {
                return Some(format!(
                    "field `{prefix}{}` is {here} here and {there} there",
                    own.name
                ));
            }
            if let (FieldKind::Struct(here), FieldKind::Struct(there)) = (&own.kind, &others.kind)
                && let Some(difference) = here.difference_in(&format!("{prefix}{}.", own.name), there)
            {
                return Some(difference);
            }
            if own.offset != others.offset {
                let (here, there) = (own.offset, others.offset);
                return Some(format!(
                    "field `{prefix}{}` is at byte {here} here and {there} there",
                    own.name
                ));
            }
        }
        let additional_field = |longer: &Self, shorter: &Self| {
            let field = longer.fields.get(shorter.fields.len())?;
            Some(format!("`{prefix}{}`", field.name))
        };
        if let Some(field) = additional_field(self, other) {
            return Some(format!("field {field} is here and not there"));
        }
        if let Some(field) = additional_field(other, self) {
            return Some(format!("field {field} is there and not here"));
        }
        (!self.same_as(other)).then(|| format!("it has {} bytes here and {} there", self.bytes, other.bytes))
    }
}

impl Field {
    /// Returns its type for messages: `float32[<=1088]`.
    #[must_use]
    pub fn shape(&self) -> String {
        let kind = match &self.kind {
            FieldKind::Scalar(scalar) => scalar.ros_name(),
            FieldKind::Struct(ty) => &ty.name,
        };
        match self.form {
            Form::One => kind.to_owned(),
            Form::Array(count) => format!("{kind}[{count}]"),
            Form::Sequence { capacity, .. } => format!("{kind}[<={capacity}]"),
            Form::Text { capacity, .. } => format!("string<={capacity}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::describe::{RosNotation, Scalar};

    fn ty(name: &str, fields: &[(&str, FieldKind, Form)]) -> Type {
        let mut bytes = 0;
        let fields = fields.iter().map(|(name, kind, form)| {
            let offset = bytes;
            bytes += kind.bytes() * form.capacity();
            Field {
                name: (*name).to_owned(),
                doc: String::new(),
                unit: String::new(),
                kind: kind.clone(),
                form: *form,
                offset,
                notation: RosNotation::default(),
            }
        });
        let fields = fields.collect();
        Type {
            name: name.to_owned(),
            doc: String::new(),
            bytes,
            align: 8,
            fields,
        }
    }

    #[test]
    fn the_first_difference_is_returned() {
        let number = |scalar| FieldKind::Scalar(scalar);
        let (f32, f64) = (number(Scalar::F32), number(Scalar::F64));
        let point = |kind: &FieldKind| ty("P", &[("x", kind.clone(), Form::One)]);
        let whole = |name: &str, form, inner: Type| {
            ty(
                "W",
                &[
                    (name, f64.clone(), form),
                    ("at", FieldKind::Struct(Arc::new(inner)), Form::One),
                ],
            )
        };
        let original = whole("a", Form::Array(2), point(&f64));
        let check =
            |other: &Type, expected: &str| assert_eq!(original.difference(other).as_deref(), Some(expected));
        assert_eq!(original.difference(&original), None);
        check(
            &whole("b", Form::Array(2), point(&f64)),
            "field `a` here is `b` there",
        );
        check(
            &whole("a", Form::Array(3), point(&f64)),
            "field `a` is float64[2] here and float64[3] there",
        );
        check(
            &whole("a", Form::Array(2), point(&f32)),
            "field `at.x` is float64 here and float32 there",
        );
        let mut shorter = original.clone();
        shorter.fields.pop();
        check(&shorter, "field `at` is here and not there");
    }
}
