//! The options in the attribute of a field. Each may occur once, and only where it has a meaning.

use jde_abi::describe as abi;
use syn::meta::ParseNestedMeta;
use syn::{Attribute, Expr, Lit, LitStr, Meta, Result};

/// The options of one attribute, and the names of those it may have.
#[derive(Default)]
pub(super) struct Options {
    allowed: Vec<&'static str>,
    pub(super) name: Option<LitStr>,
    pub(super) was: Option<LitStr>,
    pub(super) unit: Option<LitStr>,
    pub(super) group: Option<LitStr>,
    pub(super) child: Option<LitStr>,
    pub(super) validity: Option<LitStr>,
    pub(super) default: Option<Expr>,
    pub(super) neutral: Option<Expr>,
    pub(super) min: Option<Expr>,
    pub(super) max: Option<Expr>,
    /// The flags of the attributes that the ABI lists.
    pub(super) flags: u32,
    pub(super) lasting: bool,
    pub(super) perceptive: bool,
}

impl Options {
    /// Reads `attribute`, which may have the options `allowed`.
    pub(super) fn of(attribute: &Attribute, allowed: Vec<&'static str>) -> Result<Self> {
        let mut this = Self {
            allowed,
            ..Self::default()
        };
        if !matches!(attribute.meta, Meta::Path(_)) {
            attribute.parse_nested_meta(|meta| this.take(&meta))?;
        }
        Ok(this)
    }

    fn take(&mut self, meta: &ParseNestedMeta<'_>) -> Result<()> {
        let option = meta.path.get_ident().map(ToString::to_string).unwrap_or_default();
        if !self.allowed.contains(&option.as_str()) {
            return Err(meta.error(format!(
                "unknown option; expected one of {}",
                self.allowed.join(", ")
            )));
        }
        let is_duplicate = match option.as_str() {
            "name" => self.name.replace(meta.value()?.parse()?).is_some(),
            "was" => self.was.replace(meta.value()?.parse()?).is_some(),
            "unit" => self.unit.replace(meta.value()?.parse()?).is_some(),
            "group" => self.group.replace(meta.value()?.parse()?).is_some(),
            "child" => self.child.replace(meta.value()?.parse()?).is_some(),
            "validity" => self.validity.replace(meta.value()?.parse()?).is_some(),
            "default" => self.default.replace(meta.value()?.parse()?).is_some(),
            "neutral" => self.neutral.replace(meta.value()?.parse()?).is_some(),
            "min" => self.min.replace(meta.value()?.parse()?).is_some(),
            "max" => self.max.replace(meta.value()?.parse()?).is_some(),
            "lasting" => std::mem::replace(&mut self.lasting, true),
            "perceptive" => std::mem::replace(&mut self.perceptive, true),
            attribute => {
                let flag = abi::Attribute::flag(attribute);
                let is_set = self.flags & flag != 0;
                self.flags |= flag;
                is_set
            }
        };
        if is_duplicate {
            return Err(meta.error("this option occurs twice"));
        }
        Ok(())
    }
}

/// Returns whether an expression is a text literal.
pub(super) fn is_text(expr: &Expr) -> bool {
    matches!(expr, Expr::Lit(literal) if matches!(literal.lit, Lit::Str(_)))
}
