//! How a group competes: the policy for collisions, the absence policy, patience, budget, guard and retry.
//! Refuses keys without effect.

use jde_core::{
    Absence, DEFAULT_BUDGET, DEFAULT_PATIENCE, DEFAULT_RETRY, Nanos, NumberParameter, POLICIES, Policy,
    PolicyKind, SchemaId,
};

use super::GroupConfig;
use super::drafts::Drafts;
use super::guards;
use super::time;
use jde_document::section::{Section, number, report_wrong_shape};
use jde_document::{FaultReport, quote};

/// The keys beside those of the policies.
const KEYS: &[&str] = &[
    "members", "policy", "absence", "hold", "fallback", "patience", "budget", "guard", "retry",
];
const ABSENCES: &[&str] = &["brake", "hold", "fallback"];

/// The contents of a group's own keys.
pub(super) struct GroupSettings {
    policy: Policy,
    absence: Absence,
    patience_ns: Nanos,
    budget_ns: Nanos,
    guard: Option<SchemaId>,
    retry_ns: Nanos,
}

/// The group whose settings are read.
pub(super) struct GroupContext<'n> {
    pub(super) drafts: &'n Drafts<'n>,
    /// Whether the father has an arbitration function.
    pub(super) arbitrates: bool,
    /// Whether the file lists the members, as `members`.
    pub(super) lists: bool,
    /// What the names of the members denote: "roles of this group".
    pub(super) members_noun: &'n str,
    /// The members by name, as possible fallbacks.
    pub(super) members: &'n [(&'n str, SchemaId)],
}

impl GroupSettings {
    /// Reads the keys of a group; without a section, returns the defaults.
    pub(super) fn read(report: &mut FaultReport, section: Option<&Section>, context: &GroupContext) -> Self {
        let arbitrates = context.arbitrates;
        let default = if arbitrates {
            Policy::FATHER
        } else {
            Policy::PRIORITY
        };
        let Some(section) = section else {
            return Self {
                policy: default,
                absence: Absence::Brake,
                patience_ns: DEFAULT_PATIENCE,
                budget_ns: DEFAULT_BUDGET,
                guard: None,
                retry_ns: DEFAULT_RETRY,
            };
        };
        let keys = &KEYS[usize::from(!context.lists)..];
        section.refuse_unknown(report, &[keys, &policy_keys()].concat());
        Self {
            policy: policy(report, section, default, arbitrates),
            absence: absence(report, section, context),
            patience_ns: time::of(report, section, "patience").unwrap_or(DEFAULT_PATIENCE),
            budget_ns: time::of(report, section, "budget").unwrap_or(DEFAULT_BUDGET),
            guard: guards::named(report, context.drafts, section),
            retry_ns: time::of(report, section, "retry").unwrap_or(DEFAULT_RETRY),
        }
    }

    pub(super) fn group(self, name: String, father: Option<SchemaId>, members: Vec<SchemaId>) -> GroupConfig {
        GroupConfig {
            name,
            father,
            members,
            policy: self.policy,
            absence: self.absence,
            patience_ns: self.patience_ns,
            budget_ns: self.budget_ns,
            guard: self.guard,
            retry_ns: self.retry_ns,
        }
    }
}

/// The keys of all policies, each once.
fn policy_keys() -> Vec<&'static str> {
    let mut keys: Vec<&str> = POLICIES.iter().flat_map(|kind| parameter_keys(kind)).collect();
    keys.sort_unstable();
    keys.dedup();
    keys
}

fn parameter_keys(kind: &PolicyKind) -> impl Iterator<Item = &'static str> {
    let time = kind.time.iter().map(|time| time.key);
    time.chain(kind.number.iter().map(|number| number.key))
}

fn policy(report: &mut FaultReport, section: &Section, default: Policy, arbitrates: bool) -> Policy {
    let written = section.text(report, "policy");
    let name = written.as_ref().map(|written| written.text);
    let kind = name.and_then(PolicyKind::named);
    for key in policy_keys() {
        let users = POLICIES
            .iter()
            .filter(|kind| parameter_keys(kind).any(|of| of == key));
        let users: Vec<&str> = users.map(|kind| kind.name).collect();
        only_with(report, section, key, "policy", &users, name);
    }
    let (Some(written), Some(kind)) = (&written, kind) else {
        if let Some(written) = written {
            report
                .fault(
                    &written.span,
                    format!("{} has no policy {}", section.label, quote(written.text)),
                )
                .suggest(written.text, "policies", POLICIES.iter().map(|kind| kind.name));
        }
        return default;
    };
    let policy = Policy::new(
        kind,
        kind.time.as_ref().map_or(0, |parameter| {
            require_key(
                report,
                section,
                "policy",
                kind.name,
                parameter.key,
                &format!("{:?}", parameter.example),
            );
            time::of(report, section, parameter.key).unwrap_or_default()
        }),
        kind.number
            .as_ref()
            .map_or(0.0, |parameter| number_of(report, section, parameter)),
    );
    if policy == Policy::FATHER && !arbitrates {
        let ready_made: Vec<String> = POLICIES
            .iter()
            .filter(|kind| kind.name != policy.name())
            .map(|kind| format!("`{}`", kind.name))
            .collect();
        let (last, others) = ready_made.split_last().expect("there are policies");
        report
            .fault(
                &written.span,
                format!(
                    "{} is \"father\", and the group has no father with an arbitration",
                    section.key("policy")
                ),
            )
            .advise(format!("choose {} or {last}", others.join(", ")));
    }
    policy
}

fn absence(
    report: &mut FaultReport,
    section: &Section,
    &GroupContext {
        members_noun,
        members,
        ..
    }: &GroupContext,
) -> Absence {
    let written = section.text(report, "absence");
    let name = written.as_ref().map(|written| written.text);
    let hold = time::of(report, section, "hold");
    let fallback = section.text(report, "fallback").and_then(|role| {
        let member = members.iter().find(|(name, _)| *name == role.text);
        if member.is_none() {
            report
                .fault(
                    &role.span,
                    format!(
                        "{} is {}, which is not a member of the group",
                        section.key("fallback"),
                        quote(role.text)
                    ),
                )
                .suggest(role.text, members_noun, members.iter().map(|(name, _)| *name));
        }
        member.map(|(_, child)| *child)
    });
    only_with(report, section, "hold", "absence", &["hold"], name);
    only_with(report, section, "fallback", "absence", &["fallback"], name);
    let Some(written) = written else {
        return Absence::Brake;
    };
    match written.text {
        "brake" => Absence::Brake,
        "hold" => {
            require_key(report, section, "absence", "hold", "hold", "\"300ms\"");
            Absence::Hold {
                for_: hold.unwrap_or_default(),
            }
        }
        "fallback" => {
            let example = members.first().map_or("a role", |(name, _)| *name);
            require_key(
                report,
                section,
                "absence",
                "fallback",
                "fallback",
                &format!("\"{example}\""),
            );
            fallback.map_or(Absence::Brake, Absence::Fallback)
        }
        other => {
            report
                .fault(
                    &written.span,
                    format!("{} has no absence policy {}", section.label, quote(other)),
                )
                .suggest(other, "absence policies", ABSENCES.iter().copied());
            Absence::Brake
        }
    }
}

fn number_of(report: &mut FaultReport, section: &Section, parameter: &NumberParameter) -> f64 {
    let Some(node) = section.get(parameter.key) else {
        return 0.0;
    };
    let what = section.key(parameter.key);
    match number(node.get_ref()) {
        Some(value) if value.is_finite() && value >= 0.0 => value,
        Some(_) => {
            report
                .fault(
                    &node.span(),
                    format!("{what} is not a finite number of 0 or more"),
                )
                .advise(format!("give {}", parameter.meaning));
            0.0
        }
        None => {
            report_wrong_shape(report, &what, "a number, 0 or more", node);
            0.0
        }
    }
}

/// Reports a key that has no meaning without a certain value of another.
fn only_with(
    report: &mut FaultReport,
    section: &Section,
    key: &str,
    of: &str,
    needed: &[&str],
    given: Option<&str>,
) {
    if section.get(key).is_some()
        && given.is_none_or(|given| !needed.contains(&given))
        && section.get(of).is_none_or(|node| node.get_ref().is_str())
    {
        let needed = needed.join("\" or \"");
        report
            .fault(
                &section.key_span(key),
                format!("{} has an effect only with {of} = \"{needed}\"", section.key(key)),
            )
            .advise(format!("remove it, or write {of} = \"{needed}\""));
    }
}

/// Reports a key that another one requires and that is missing.
fn require_key(
    report: &mut FaultReport,
    section: &Section,
    key: &str,
    value: &str,
    needed: &str,
    example: &str,
) {
    if section.get(needed).is_none() {
        let span = section.get(key).map_or(section.span.clone(), |node| node.span());
        report
            .fault(
                &span,
                format!("{} is \"{value}\", which requires `{needed}`", section.key(key)),
            )
            .advise(format!("add {needed} = {example}"));
    }
}
