//! Checks whether another build of a type fits a running application: every present binding must still hold,
//! and no new port or role may require one. Collects all reasons against it; changes nothing.

use jde_abi::describe::{Child, Kind, Port, Role, Schema};
use jde_app::{Application, Binding, ChildTarget, ImportSource, InstanceConfig};
use jde_core::Policy;

use super::PortMapping;

/// How a build fits.
pub struct BuildMapping {
    /// Where each port of the build leads.
    pub ports: Vec<PortMapping>,
    /// For each role of the build, the application's role.
    pub roles: Vec<Option<usize>>,
    /// New parts of the build that take effect only when the application is restarted.
    pub notes: Vec<String>,
}

/// The present build and the new one, with the findings so far.
struct CompatibilityCheck<'a> {
    application: &'a Application,
    number: usize,
    new: &'a Schema,
    errors: Vec<String>,
    notes: Vec<String>,
}

/// Maps a build's ports and roles to those of the application.
///
/// # Errors
/// Every reason why it cannot replace the present build.
pub fn map_build(
    application: &Application,
    number: usize,
    new: &Schema,
) -> Result<BuildMapping, Vec<String>> {
    let children = application.instances[number].schema.children.iter();
    let named = children.filter(|child| child.many);
    let new = &new.with_children(named.map(|child| (&*child.name, &*child.group)));
    let mut fitting = CompatibilityCheck {
        application,
        number,
        new,
        errors: Vec::new(),
        notes: Vec::new(),
    };
    fitting.check_type();
    fitting.check_removed();
    let roles: Vec<_> = new.children.iter().map(|child| fitting.map_role(child)).collect();
    let ports = new.ports.iter().map(|port| fitting.map_port(port)).collect();
    if fitting.errors.is_empty() {
        Ok(BuildMapping {
            ports,
            roles,
            notes: fitting.notes,
        })
    } else {
        Err(fitting.errors)
    }
}

impl<'a> CompatibilityCheck<'a> {
    fn instance(&self) -> &'a InstanceConfig {
        &self.application.instances[self.number]
    }

    fn old(&self) -> &'a Schema {
        &self.instance().schema
    }

    /// Checks the type as a whole.
    fn check_type(&mut self) {
        let (old, new) = (self.old(), self.new);
        if old.kind != new.kind {
            let kinds = (kind_noun(old.kind), kind_noun(new.kind));
            self.errors
                .push(format!("it is {} now, and was {}", kinds.1, kinds.0));
        }
        let number = self.number;
        let groups = self.application.groups.iter();
        let asked = groups.filter(|group| group.father == Some(number) && group.policy == Policy::FATHER);
        if !new.arbitrates && old.arbitrates {
            for group in asked {
                self.errors.push(format!(
                    "the group {} is arbitrated by its own function, and it has none any more",
                    group.name
                ));
            }
        }
        let budget = |schema: &Schema| schema.budget_ns.unwrap_or(schema.period_ns);
        for (what, then, now) in [
            ("period", old.period_ns, new.period_ns),
            ("budget", budget(old), budget(new)),
        ] {
            if then != now {
                self.notes.push(format!(
                    "its {what} is {} ms by default now; the running one stays",
                    now as f64 / 1e6
                ));
            }
        }
    }

    /// Finds removed ports and roles that the application needs.
    fn check_removed(&mut self) {
        let instance = self.instance();
        for (place, port) in self.old().ports.iter().enumerate() {
            if self.new.ports.iter().any(|new| self.has_same_name(new, port)) {
                continue;
            }
            if let Some(need) = self.describe_need(place, &instance.bindings[place]) {
                let name = self.port_name(port, &self.old().children);
                self.errors.push(format!("{name} is gone, and {need}"));
            }
        }
        for (place, child) in self.old().children.iter().enumerate() {
            let gone = !self.new.children.iter().any(|new| new.name == child.name);
            if let (true, Some(bound)) = (gone, instance.children[place]) {
                self.errors.push(format!(
                    "the child `{}` is gone, and {} has its role",
                    child.name,
                    self.schema_name(bound)
                ));
            }
        }
    }

    /// Describes why a port of the present build is needed; `None` if it is not.
    fn describe_need(&self, place: usize, binding: &Binding) -> Option<String> {
        let here = (self.number, place);
        match binding {
            Binding::Import { source, .. } => {
                let source = self.application.source_name((*source)?);
                Some(format!("the application binds it to {source}"))
            }
            Binding::Actuator { target } => {
                let target = target.as_ref()?;
                Some(format!(
                    "the application binds it to {}",
                    self.variable_name(*target)
                ))
            }
            // These are not bound by hand: if a father no longer writes one, the child keeps its value.
            Binding::ChildModulation { .. } => None,
            Binding::Export => self
                .reader(here)
                .or_else(|| (self.application.mission == Some(here)).then(|| "it is the mission".to_owned())),
            Binding::Command => self.writer(here),
            Binding::Modulation { set, .. } => {
                // The next start of the application would be refused, whatever the value.
                let set = || set.then(|| "the application sets it".to_owned());
                self.writer(here).or_else(|| self.reader(here)).or_else(set)
            }
        }
    }

    fn reader(&self, variable: (usize, usize)) -> Option<String> {
        let reads = |binding: &Binding| {
            matches!(binding, Binding::Import { source: Some(ImportSource::Local(owner, port)), .. }
                if (*owner, *port) == variable)
        };
        self.user(reads).map(|user| format!("{user} imports it"))
    }

    fn writer(&self, variable: (usize, usize)) -> Option<String> {
        let writes = |binding: &Binding| match binding {
            Binding::Actuator { target } => *target == Some(variable),
            Binding::ChildModulation {
                target: Some(ChildTarget::Port(child, port)),
            } => (*child, *port) == variable,
            Binding::ChildModulation { .. }
            | Binding::Import { .. }
            | Binding::Export
            | Binding::Modulation { .. }
            | Binding::Command => false,
        };
        self.user(writes).map(|user| format!("{user} writes it"))
    }

    fn user(&self, uses: impl Fn(&Binding) -> bool) -> Option<String> {
        let mut instances = self.application.instances.iter();
        let user = instances.find(|instance| instance.bindings.iter().any(&uses))?;
        Some(user.name.clone())
    }

    /// Returns the application's place of a role.
    fn map_role(&mut self, new: &Child) -> Option<usize> {
        let place = self.old().children.iter().position(|old| old.name == new.name);
        let bound = place.and_then(|place| self.instance().children[place]);
        match place {
            Some(place) => {
                let old = &self.old().children[place];
                if bound.is_some() && (old.motor != new.motor || old.group != new.group) {
                    self.errors.push(format!(
                        "the child `{}` is {} now, and {} has its role as {}",
                        new.name,
                        describe_child(new),
                        bound.map_or_else(String::new, |bound| self.schema_name(bound)),
                        describe_child(old)
                    ));
                }
            }
            None if new.optional => self.notes.push(format!(
                "the child `{}` is new: nobody has its role before the application starts anew",
                new.name
            )),
            None => {}
        }
        if bound.is_none() && !new.optional {
            self.errors.push(format!(
                "the child `{}` is not optional, and nobody has its role in the application",
                new.name
            ));
        }
        place
    }

    /// Returns where a port leads.
    fn map_port(&mut self, new: &Port) -> PortMapping {
        let place = self
            .old()
            .ports
            .iter()
            .position(|old| self.has_same_name(new, old));
        let Some(place) = place else {
            return self.map_new_port(new);
        };
        let instance = self.instance();
        let old = &instance.schema.ports[place];
        let name = self.port_name(new, &self.new.children);
        let unbound = matches!(
            instance.bindings[place],
            Binding::Import { source: None, .. }
                | Binding::Actuator { target: None }
                | Binding::ChildModulation { target: None }
        );
        if unbound && !new.optional {
            self.errors.push(format!(
                "{name} is not optional any more, and the application leaves it unbound"
            ));
        }
        if !unbound {
            self.check_port(&name, old, new);
        }
        PortMapping::Bound(place)
    }

    /// Checks that a bound port has not changed.
    fn check_port(&mut self, name: &str, old: &Port, new: &Port) {
        if !old.value_type.same_as(&new.value_type) {
            let what = if old.value_type.name == new.value_type.name {
                "laid out otherwise".to_owned()
            } else {
                format!("a {} now", new.value_type.name)
            };
            self.errors
                .push(format!("{name} is {what}, and was a {}", old.value_type.name));
        }
        if old.unit != new.unit {
            let unit = |unit: &str| match unit {
                "" => "no unit".to_owned(),
                unit => format!("`{unit}`"),
            };
            self.errors.push(format!(
                "{name} is in {} now, and was in {}",
                unit(&new.unit),
                unit(&old.unit)
            ));
        }
        match (&old.role, &new.role) {
            (
                Role::Command { neutral, validity_ns },
                Role::Command {
                    neutral: new_neutral,
                    validity_ns: new_validity,
                },
            ) if neutral != new_neutral || validity_ns != new_validity => self.errors.push(format!(
                "{name} has another neutral value or validity, by which actuators are stopped"
            )),
            (Role::Import { trigger }, Role::Import { trigger: new_trigger }) if trigger != new_trigger => {
                self.notes.push(format!(
                    "{name} is {} trigger by default now; the application keeps it as it was",
                    if *new_trigger { "a" } else { "no" }
                ));
            }
            (
                Role::Modulation {
                    default,
                    limits,
                    fixed,
                },
                Role::Modulation {
                    default: new_default,
                    limits: new_limits,
                    fixed: new_fixed,
                },
            ) => {
                if default != new_default {
                    self.notes.push(format!(
                        "{name} has another default now; the running value stays (`jde set`)"
                    ));
                }
                if fixed != new_fixed {
                    self.notes.push(format!(
                        "{name} is {} on awakening now; it is so from when the application starts anew",
                        if *new_fixed { "taken" } else { "no longer taken" }
                    ));
                }
                if limits != new_limits {
                    self.notes.push(format!(
                        "{name} has other limits now; the old ones count before the application starts anew"
                    ));
                }
            }
            _ => {}
        }
    }

    /// Returns where a port leads that the application does not know.
    fn map_new_port(&mut self, new: &Port) -> PortMapping {
        let name = self.port_name(new, &self.new.children);
        let way = match &new.role {
            Role::Import { .. } | Role::Actuator if !new.optional => {
                self.errors.push(format!(
                    "{name} is new and not optional, and the application does not bind it"
                ));
                return PortMapping::Unbound;
            }
            Role::ChildModulation { child } => {
                let role = &self.new.children[*child].name;
                let old = self.old().children.iter().position(|old| old.name == *role);
                if !new.optional && old.is_some_and(|old| self.instance().children[old].is_some()) {
                    self.errors.push(format!(
                        "{name} is new and not optional, and the application does not bind it"
                    ));
                }
                PortMapping::Unbound
            }
            Role::Import { .. } | Role::Actuator => PortMapping::Unbound,
            Role::Modulation { default, .. } => PortMapping::fixed(default, false),
            Role::Command { neutral, .. } => PortMapping::fixed(neutral, true),
            Role::Export => PortMapping::Discarded(new.value_type.bytes),
        };
        self.notes.push(match &way {
            PortMapping::Fixed { neutral: false, .. } => {
                format!("{name} is new: it has its default before the application starts anew")
            }
            PortMapping::Fixed { neutral: true, .. } => {
                format!("{name} is new: nobody commands it before the application starts anew")
            }
            PortMapping::Discarded(_) => {
                format!("{name} is new: nobody sees it before the application starts anew")
            }
            PortMapping::Unbound | PortMapping::Bound(_) => {
                format!("{name} is new: it stays unbound before the application starts anew")
            }
        });
        way
    }

    /// Whether two ports agree in kind, name and child.
    fn has_same_name(&self, new: &Port, old: &Port) -> bool {
        let child = |port: &Port, children: &'a [Child]| match port.role {
            Role::ChildModulation { child } => Some(children[child].name.as_str()),
            Role::Import { .. }
            | Role::Export
            | Role::Modulation { .. }
            | Role::Command { .. }
            | Role::Actuator => None,
        };
        new.name == old.name
            && role_noun(&new.role) == role_noun(&old.role)
            && child(new, &self.new.children) == child(old, &self.old().children)
    }

    fn port_name(&self, port: &Port, children: &[Child]) -> String {
        match port.role {
            Role::ChildModulation { child } => {
                format!(
                    "the modulation `{}` of the child `{}`",
                    port.name, children[child].name
                )
            }
            _ => format!("the {} `{}`", role_noun(&port.role), port.name),
        }
    }

    fn schema_name(&self, place: usize) -> String {
        self.application.instances[place].name.clone()
    }

    fn variable_name(&self, (owner, port): (usize, usize)) -> String {
        let owner = &self.application.instances[owner];
        format!("{}.{}", owner.name, owner.schema.ports[port].name)
    }
}

fn kind_noun(kind: Kind) -> &'static str {
    match kind {
        Kind::Perceptive => "perceptive",
        Kind::Motor => "a motor schema",
        Kind::Driver => "a driver",
    }
}

fn role_noun(role: &Role) -> &'static str {
    match role {
        Role::Import { .. } => "import",
        Role::Export => "export",
        Role::Modulation { .. } => "modulation",
        Role::Command { .. } => "command",
        Role::Actuator => "actuator",
        Role::ChildModulation { .. } => "modulation of a child",
    }
}

fn describe_child(child: &Child) -> String {
    if child.motor {
        format!("a motor schema of the group `{}`", child.group)
    } else {
        "perceptive".to_owned()
    }
}
