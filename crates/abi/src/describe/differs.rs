//! In what two types of one name differ: the words that help whoever built two plugins with two definitions of it.

use super::{Field, FieldKind, Form, Type};

impl Type {
    /// The first thing in which the layouts differ, "field `speed` is float64 here and float32 there"; nothing if they do not.
    #[must_use]
    pub fn difference(&self, there: &Self) -> Option<String> {
        self.difference_in("", there)
    }

    fn difference_in(&self, within: &str, there: &Self) -> Option<String> {
        for (one, other) in self.fields.iter().zip(&there.fields) {
            if one.name != other.name {
                return Some(format!(
                    "field `{within}{}` here is `{within}{}` there",
                    one.name, other.name
                ));
            }
            let (here, there) = (one.shape(), other.shape());
            if here != there {
                return Some(format!(
                    "field `{within}{}` is {here} here and {there} there",
                    one.name
                ));
            }
            if let (FieldKind::Struct(here), FieldKind::Struct(there)) = (&one.kind, &other.kind)
                && let Some(difference) = here.difference_in(&format!("{within}{}.", one.name), there)
            {
                return Some(difference);
            }
            if one.offset != other.offset {
                let (here, there) = (one.offset, other.offset);
                return Some(format!(
                    "field `{within}{}` is at byte {here} here and {there} there",
                    one.name
                ));
            }
        }
        let more = |longer: &Self, shorter: &Self| {
            let field = longer.fields.get(shorter.fields.len())?;
            Some(format!("`{within}{}`", field.name))
        };
        if let Some(field) = more(self, there) {
            return Some(format!("field {field} is here and not there"));
        }
        if let Some(field) = more(there, self) {
            return Some(format!("field {field} is there and not here"));
        }
        (!self.same_as(there)).then(|| format!("it has {} bytes here and {} there", self.bytes, there.bytes))
    }
}

impl Field {
    /// What it is, in a word or two: `float32[<=1088]`.
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
    use crate::describe::Scalar;

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
    fn the_first_field_that_differs_is_named() {
        let number = |scalar| FieldKind::Scalar(scalar);
        let (f32, f64) = (number(Scalar::F32), number(Scalar::F64));
        let one = |kind: &FieldKind| ty("P", &[("x", kind.clone(), Form::One)]);
        let whole = |name: &str, form, inner: Type| {
            ty(
                "W",
                &[
                    (name, f64.clone(), form),
                    ("at", FieldKind::Struct(Arc::new(inner)), Form::One),
                ],
            )
        };
        let here = whole("a", Form::Array(2), one(&f64));
        let check = |there: &Type, words: &str| assert_eq!(here.difference(there).as_deref(), Some(words));
        assert_eq!(here.difference(&here), None);
        check(
            &whole("b", Form::Array(2), one(&f64)),
            "field `a` here is `b` there",
        );
        check(
            &whole("a", Form::Array(3), one(&f64)),
            "field `a` is float64[2] here and float64[3] there",
        );
        check(
            &whole("a", Form::Array(2), one(&f32)),
            "field `at.x` is float64 here and float32 there",
        );
        let mut shorter = here.clone();
        shorter.fields.pop();
        check(&shorter, "field `at` is here and not there");
    }
}
