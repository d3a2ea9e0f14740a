//! A field of a schema: a port, a child, or memory.

use jde_abi::describe::{ATTRIBUTES, Attribute};
use jde_abi::raw;
use proc_macro2::{Span, TokenStream};
use quote::{quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Error, Expr, GenericArgument, Ident, LitStr, PathArguments, Result, Type};

use super::options::{Options, is_text};
use crate::text::{c, check_name, doc, duration, unit};

/// A field of a schema.
pub(super) struct SchemaField {
    pub(super) member: Ident,
    pub(super) ty: Type,
    pub(super) span: Span,
    pub(super) name: String,
    pub(super) role: Role,
    /// The flags of its attributes.
    flags: u32,
    doc: String,
    unit: String,
    /// The `T` of a port.
    value: Option<Type>,
}

/// The role of a field.
#[allow(clippy::large_enum_variant, reason = "only a few exist during a compilation")]
pub(super) enum Role {
    Memory,
    /// A bundle of ports.
    Bundle,
    Import,
    Export {
        /// 0 if the periods of the schema determine it.
        validity_ns: u64,
    },
    Modulation {
        default: Expr,
        min: Option<Expr>,
        max: Option<Expr>,
        /// The name of the versions before.
        was: Option<LitStr>,
    },
    Command {
        neutral: Expr,
        validity_ns: u64,
    },
    Actuator,
    Child {
        group: Option<LitStr>,
        many: bool,
    },
    Modulates {
        child: LitStr,
    },
    List {
        initial: Expr,
        /// Of a list of commands or exports; otherwise 0.
        validity_ns: u64,
    },
}

/// The type of a role for any number of children.
const MANY: &str = "Children";

const ONE_ROLE: &str = "a field has only one attribute for its role";

/// The validity of a lasting export in its table.
const LASTING: u64 = raw::LASTING;

/// The attribute of a bundle of ports, whose type has any name.
const BUNDLE: &str = "ports";

/// A role that a field may have.
#[derive(Clone, Copy)]
struct Kind {
    /// The name of the attribute.
    keyword: &'static str,
    /// The type of the field.
    ty: &'static str,
    /// The kind of port in the ABI, whose attributes are options too; `None` for what is no port.
    port: Option<u32>,
    /// The other options.
    options: &'static [&'static str],
}

const fn kind(
    keyword: &'static str,
    ty: &'static str,
    port: Option<u32>,
    options: &'static [&'static str],
) -> Kind {
    Kind {
        keyword,
        ty,
        port,
        options,
    }
}

const KINDS: &[Kind] = &[
    kind("import", "Import", Some(raw::IMPORT), &["unit", "name"]),
    kind(
        "export",
        "Export",
        Some(raw::EXPORT),
        &["validity", "lasting", "unit", "name"],
    ),
    kind(
        "modulation",
        "Modulation",
        Some(raw::MODULATION),
        &["default", "unit", "min", "max", "name", "was"],
    ),
    kind(
        "command",
        "Command",
        Some(raw::COMMAND),
        &["neutral", "validity", "unit", "name"],
    ),
    kind("actuator", "Actuator", Some(raw::ACTUATOR), &["unit", "name"]),
    kind(
        "child",
        "Child",
        None,
        &["group", "perceptive", "optional", "name"],
    ),
    kind("child", MANY, None, &["group", "name"]),
    kind(
        "modulates",
        "Modulates",
        Some(raw::CHILD_MODULATION),
        &["child", "unit", "name"],
    ),
    kind("imports", "Imports", None, &["default", "name"]),
    kind(
        "exports",
        "Exports",
        None,
        &["default", "validity", "lasting", "name"],
    ),
    kind("commands", "Commands", None, &["default", "validity", "name"]),
];

impl Kind {
    /// Returns the names of its options.
    fn allowed(self) -> Vec<&'static str> {
        let has = |attribute: &&Attribute| self.port.is_some_and(|port| attribute.kinds.contains(&port));
        let attributes = ATTRIBUTES.iter().filter(has).map(|attribute| attribute.name);
        attributes.chain(self.options.iter().copied()).collect()
    }
}

impl SchemaField {
    pub(super) fn of(field: &syn::Field) -> Result<Self> {
        let Some(member) = field.ident.clone() else {
            return Err(Error::new_spanned(field, "a schema has named fields"));
        };
        let mut this = Self {
            span: member.span(),
            name: member.to_string().trim_start_matches("r#").to_owned(),
            member,
            ty: field.ty.clone(),
            role: Role::Memory,
            flags: 0,
            doc: doc(&field.attrs),
            unit: String::new(),
            value: None,
        };
        let mut attributes = field.attrs.iter().filter_map(kind_of);
        if let Some(bundle) = field
            .attrs
            .iter()
            .find(|attribute| attribute.path().is_ident(BUNDLE))
        {
            bundle.meta.require_path_only()?;
            if let Some((second, _)) = attributes.next() {
                return Err(Error::new_spanned(second, ONE_ROLE));
            }
            this.role = Role::Bundle;
            return Ok(this);
        }
        let (type_name, argument) = last_segment(&field.ty);
        let Some((attribute, first)) = attributes.next() else {
            if let Some(kind) = KINDS.iter().find(|kind| kind.ty == type_name) {
                return Err(Error::new_spanned(
                    &field.ty,
                    format!(
                        "a field of type `{type_name}` needs the attribute #[{}]",
                        kind.keyword
                    ),
                ));
            }
            return Ok(this);
        };
        if let Some((second, _)) = attributes.next() {
            return Err(Error::new_spanned(second, ONE_ROLE));
        }
        let matches = |kind: &&Kind| kind.keyword == first.keyword && kind.ty == type_name;
        let kind = *KINDS.iter().find(matches).unwrap_or(&first);
        let (keyword, expected) = (kind.keyword, kind.ty);
        if type_name != expected {
            let generic = if expected == "Child" { "" } else { "<...>" };
            return Err(Error::new_spanned(
                &field.ty,
                format!("a field with #[{keyword}] has the type `{expected}{generic}`"),
            ));
        }
        if keyword != "child" && argument.is_none() {
            return Err(Error::new_spanned(
                &field.ty,
                format!("state the type of the value, such as `{expected}<LaserScan>`"),
            ));
        }
        this.value = argument;
        let options = Options::of(attribute, kind.allowed())?;
        for name in options.name.iter().chain(&options.was) {
            check_name(&name.value(), name.span())?;
        }
        if let Some(name) = &options.name {
            this.name = name.value();
        }
        this.unit = unit(options.unit.as_ref())?;
        this.flags = options.flags;
        this.role = role(keyword, expected == MANY, attribute, options)?;
        Ok(this)
    }

    /// Returns whether the field is a role for a child.
    pub(super) fn is_child(&self) -> bool {
        matches!(self.role, Role::Child { .. })
    }

    /// Returns the field's name space, in which names must be unique. `None` for memory.
    pub(super) fn name_space(&self) -> Option<String> {
        match &self.role {
            Role::Memory | Role::Bundle => None,
            Role::Import => Some("imports".into()),
            Role::Actuator => Some("actuators".into()),
            Role::Child { .. } => Some("children".into()),
            Role::Modulates { child, .. } => Some(format!("modulations of {}", child.value())),
            Role::Export { .. } | Role::Modulation { .. } | Role::Command { .. } => Some("variables".into()),
            Role::List { .. } => Some("lists".into()),
        }
    }

    /// Generates the table of a port. `child` is the index of the child whose modulation it is.
    pub(super) fn port_table(&self, child: Option<usize>) -> TokenStream {
        let Some(ty) = &self.value else {
            return TokenStream::new();
        };
        let (name, doc, unit) = (c(&self.name), c(&self.doc), c(&self.unit));
        let constant = |value: &Expr| {
            let span = value.span();
            let value = if is_text(value) {
                quote_spanned!(span => <#ty>::new(#value))
            } else {
                quote!(#value)
            };
            quote_spanned!(span => { const INITIAL: #ty = #value; &INITIAL })
        };
        let bound = |bound: &Option<Expr>| match bound {
            Some(bound) => quote!((#bound) as f64),
            None => quote!(f64::NAN),
        };
        let flags = self.flags;
        let table = match &self.role {
            Role::Import => quote_spanned!(ty.span() => derived::import::<#ty>(#name, #doc, #unit)),
            Role::Export { validity_ns } => {
                quote_spanned!(ty.span() => derived::export::<#ty>(#name, #doc, #unit, #validity_ns))
            }
            Role::Modulation {
                default,
                min,
                max,
                was,
            } => {
                let span = default.span();
                let value = if is_text(default) {
                    quote_spanned!(span => <#ty>::new(#default))
                } else {
                    quote!(#default)
                };
                let range_assertions = range_assertions(ty, &value, span, min.as_ref(), max.as_ref());
                let default = quote_spanned! { span => {
                    #range_assertions
                    const INITIAL: <#ty as derived::Modulated>::Wire = derived::wire::<#ty>(#value);
                    &INITIAL
                } };
                let (min, max) = (bound(min), bound(max));
                let was = c(&was.as_ref().map(LitStr::value).unwrap_or_default());
                quote_spanned! { ty.span() =>
                    derived::modulation::<#ty>((#name, #was), #doc, #unit, #default, (#min, #max))
                }
            }
            Role::Command { neutral, validity_ns } => {
                let neutral = constant(neutral);
                quote_spanned! { ty.span() =>
                    derived::command::<#ty>(#name, #doc, #unit, #neutral, #validity_ns)
                }
            }
            Role::Actuator => quote_spanned!(ty.span() => derived::actuator::<#ty>(#name, #doc, #unit)),
            Role::Modulates { .. } => {
                let child = child.unwrap_or_default() as u32;
                quote_spanned!(ty.span() => derived::child_modulation::<#ty>(#name, #doc, #unit, #child))
            }
            Role::Memory | Role::Bundle | Role::Child { .. } | Role::List { .. } => {
                return TokenStream::new();
            }
        };
        quote!(derived::with_flags(#table, #flags))
    }

    /// Generates the table of a list of ports.
    pub(super) fn list_table(&self) -> TokenStream {
        let (Role::List { initial, validity_ns }, Some(settings)) = (&self.role, &self.value) else {
            return TokenStream::new();
        };
        let (name, doc, ty) = (c(&self.name), c(&self.doc), &self.ty);
        let initial = quote_spanned!(initial.span() => { const INITIAL: #settings = #initial; &INITIAL });
        quote_spanned!(ty.span() => derived::list(<#ty>::KIND, #name, #doc, <#ty>::SETTINGS, #initial, #validity_ns))
    }

    /// Generates the table of a role for a child.
    pub(super) fn child_table(&self) -> TokenStream {
        let Role::Child { group, many } = &self.role else {
            return TokenStream::new();
        };
        let (name, doc) = (c(&self.name), c(&self.doc));
        let kind = if group.is_some() {
            quote!(MOTOR)
        } else {
            quote!(PERCEPTIVE)
        };
        let group = c(&group.as_ref().map(LitStr::value).unwrap_or_default());
        let flags = if *many {
            raw::OPTIONAL | raw::MANY
        } else {
            self.flags
        };
        quote!(derived::child(derived::raw::#kind, #name, #group, #doc, #flags))
    }
}

/// Generates assertions that a default is within its limits and that the limits are in order. Each points to
/// the mistake.
fn range_assertions(
    ty: &Type,
    value: &TokenStream,
    span: Span,
    min: Option<&Expr>,
    max: Option<&Expr>,
) -> TokenStream {
    let mut assertions = TokenStream::new();
    if let (Some(min), Some(max)) = (min, max) {
        assertions.extend(quote_spanned! { max.span() =>
            #[allow(clippy::unnecessary_cast, reason = "limits are written as any number")]
            const _: () = ::core::assert!((#min) as f64 <= (#max) as f64, "`max` is below `min`");
        });
    }
    if let Some(min) = min {
        assertions.extend(quote_spanned! { span =>
            #[allow(clippy::unnecessary_cast, reason = "limits are written as any number")]
            const _: () = { const IT: #ty = #value; ::core::assert!(IT as f64 >= (#min) as f64, "the default is below `min`") };
        });
    }
    if let Some(max) = max {
        assertions.extend(quote_spanned! { span =>
            #[allow(clippy::unnecessary_cast, reason = "limits are written as any number")]
            const _: () = { const IT: #ty = #value; ::core::assert!(IT as f64 <= (#max) as f64, "the default is above `max`") };
        });
    }
    assertions
}

fn role(keyword: &str, many: bool, attribute: &syn::Attribute, options: Options) -> Result<Role> {
    let missing = |what: &str| Error::new_spanned(attribute, what);
    let validity = || match &options.validity {
        Some(validity) => duration(validity),
        None => Err(missing(
            "state how long a command is in force without being repeated: validity = \"500ms\"",
        )),
    };
    let validity_of_export = || match (&options.validity, options.lasting) {
        (Some(validity), false) => duration(validity),
        (Some(_), true) => Err(missing("a lasting value has no validity: state one of the two")),
        (None, lasting) => Ok(if lasting { LASTING } else { 0 }),
    };
    Ok(match keyword {
        "import" => Role::Import,
        "export" => Role::Export {
            validity_ns: validity_of_export()?,
        },
        "modulation" => Role::Modulation {
            default: options.default.ok_or_else(|| {
                missing("a modulation always has a value; state the initial one: default = ...")
            })?,
            min: options.min,
            max: options.max,
            was: options.was,
        },
        "command" => {
            let neutral = options
                .neutral
                .ok_or_else(|| missing("state the value that stops the actuator: neutral = ..."))?;
            Role::Command {
                neutral,
                validity_ns: validity()?,
            }
        }
        "actuator" => Role::Actuator,
        "child" => {
            if options.perceptive == options.group.is_some() {
                return Err(missing(
                    "a motor child competes in a group, #[child(group = \"base\")]; a perceptive one is #[child(perceptive)]",
                ));
            }
            if let Some(group) = &options.group {
                check_name(&group.value(), group.span())?;
            }
            Role::Child {
                group: options.group,
                many,
            }
        }
        "imports" | "exports" | "commands" => Role::List {
            validity_ns: match keyword {
                "commands" => validity()?,
                "exports" => validity_of_export()?,
                _ => 0,
            },
            initial: options.default.ok_or_else(|| {
                missing("state the settings that an entry of the application file leaves out: default = ...")
            })?,
        },
        _ => Role::Modulates {
            child: options
                .child
                .ok_or_else(|| missing("state the child that has this modulation: child = \"...\""))?,
        },
    })
}

fn kind_of(attribute: &syn::Attribute) -> Option<(&syn::Attribute, Kind)> {
    let kind = KINDS.iter().find(|kind| attribute.path().is_ident(kind.keyword));
    kind.map(|&kind| (attribute, kind))
}

/// Returns `Import` and `LaserScan` for `jde_schema::Import<LaserScan>`.
fn last_segment(ty: &Type) -> (String, Option<Type>) {
    let Type::Path(path) = ty else {
        return (String::new(), None);
    };
    let Some(segment) = path.path.segments.last() else {
        return (String::new(), None);
    };
    let argument = match &segment.arguments {
        PathArguments::AngleBracketed(arguments) => {
            arguments.args.iter().find_map(|argument| match argument {
                GenericArgument::Type(ty) => Some(ty.clone()),
                _ => None,
            })
        }
        PathArguments::None | PathArguments::Parenthesized(_) => None,
    };
    (segment.ident.to_string(), argument)
}
