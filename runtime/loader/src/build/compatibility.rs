//! Checks whether another build of a type fits a running application: every current binding must still hold,
//! and no new port or role may require one. It collects all reasons against it and changes nothing.

use jde_abi::describe::{Child, Kind, Port, Role, Schema};
use jde_abi::raw;
use jde_app::{Application, Binding, ChildTarget, ImportSource, InstanceConfig, InstancePort, RoleId};
use jde_core::{Id, Policy, SchemaId};

use super::PortMapping;

/// The mapping of a build.
pub struct BuildMapping {
    /// The mapping of each port of the build.
    pub ports: Vec<PortMapping>,
    /// For each role of the build, the application's role.
    pub roles: Vec<Option<RoleId>>,
    /// New parts of the build that take effect only when the application is restarted.
    pub notes: Vec<String>,
}

/// The current build and the new one, with the findings so far.
struct CompatibilityCheck<'a> {
    application: &'a Application,
    id: SchemaId,
    new: &'a Schema,
    errors: Vec<String>,
    notes: Vec<String>,
}

/// Maps a build's ports and roles to those of the application.
///
/// # Errors
/// Every reason why it cannot replace the current build.
pub fn map_build(application: &Application, id: SchemaId, new: &Schema) -> Result<BuildMapping, Vec<String>> {
    let children = application.instances[id].schema.children.iter();
    let named = children.filter(|child| child.many);
    let listed = application.instances[id].listed_ports();
    let new = new.with_children(named.map(|child| (&*child.name, &*child.group)));
    let new = &new.with_ports(listed.iter().cloned());
    let mut check = CompatibilityCheck {
        application,
        id,
        new,
        errors: Vec::new(),
        notes: Vec::new(),
    };
    check.check_type();
    check.check_lists();
    check.check_removed();
    let roles: Vec<_> = new.children.iter().map(|child| check.map_role(child)).collect();
    let ports = new.ports.iter().map(|port| check.map_port(port)).collect();
    if check.errors.is_empty() {
        Ok(BuildMapping {
            ports,
            roles,
            notes: check.notes,
        })
    } else {
        Err(check.errors)
    }
}

impl<'a> CompatibilityCheck<'a> {
    fn instance(&self) -> &'a InstanceConfig {
        &self.application.instances[self.id]
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
        let id = self.id;
        let groups = self.application.groups.iter();
        let arbitrated = groups.filter(|group| group.father == Some(id) && group.policy == Policy::FATHER);
        if !new.arbitrates && old.arbitrates {
            for group in arbitrated {
                self.errors.push(format!(
                    "the group {} is arbitrated by the father's own function, which the new build does not have",
                    group.name
                ));
            }
        }
        if let Some(guard) = old.guard.as_ref().filter(|_| self.guarded_group().is_some()) {
            let state = &old.ports[guard.state].name;
            let fits = new.guard.as_ref().is_some_and(|new_guard| {
                new.ports[new_guard.state].name == *state && new_guard.command.same_as(&guard.command)
            });
            if !fits {
                self.errors.push(format!(
                    "it is the guard of the group {}, and the new build does not judge {} by `{state}`",
                    self.guarded_group().unwrap_or_default(),
                    guard.command.name
                ));
            }
        }
        let budget = |schema: &Schema| schema.budget_ns.unwrap_or(schema.period_ns);
        for (name, old_ns, new_ns) in [
            ("period", old.period_ns, new.period_ns),
            ("budget", budget(old), budget(new)),
        ] {
            if old_ns != new_ns {
                self.notes.push(format!(
                    "its default {name} is now {} ms; the running value is kept",
                    new_ns as f64 / 1e6
                ));
            }
        }
    }

    /// Checks that the lists of ports that the application fills in are unchanged.
    fn check_lists(&mut self) {
        let new = &self.new.lists;
        for (number, list) in self.old().lists.iter().enumerate() {
            let is_used = self.instance().listed.iter().any(|port| port.list == number);
            let is_same = new.get(number).is_some_and(|new| {
                new.name == list.name && new.kind == list.kind && new.settings.same_as(&list.settings)
            });
            if is_used && !is_same {
                self.errors.push(format!(
                    "the list `{}` is gone, or has other settings, another kind or another validity, and the application has entries in it",
                    list.name
                ));
            }
        }
        let listed = self.instance().listed_ports();
        let is_import = |port: &Port| matches!(port.role, Role::Import);
        for port in &self.new.ports[..self.new.ports.len() - listed.len()] {
            let is_twin = |other: &Port| other.name == port.name && is_import(other) == is_import(port);
            if listed.iter().any(is_twin) {
                let name = self.port_name(port, &self.new.children);
                self.errors.push(format!(
                    "{name} has the name of an entry of the application's lists"
                ));
            }
        }
    }

    /// The name of a group that this schema guards.
    fn guarded_group(&self) -> Option<&'a str> {
        let mut groups = self.application.groups.iter();
        let guarded = groups.find(|group| group.guard == Some(self.id))?;
        Some(&guarded.name)
    }

    /// Finds removed ports and roles that the application needs.
    fn check_removed(&mut self) {
        let instance = self.instance();
        for (index, port) in self.old().ports.iter().enumerate() {
            if self.new.ports.iter().any(|new| self.has_same_name(new, port)) {
                continue;
            }
            if let Some(need) = self.describe_need(index, &instance.bindings[index]) {
                let name = self.port_name(port, &self.old().children);
                self.errors.push(format!("{name} is gone, and {need}"));
            }
        }
        for (index, child) in self.old().children.iter().enumerate() {
            let gone = !self.new.children.iter().any(|new| new.name == child.name);
            if let (true, Some(bound)) = (gone, instance.children[RoleId::new(index)]) {
                self.errors.push(format!(
                    "the child `{}` is gone, and {} has its role",
                    child.name,
                    self.schema_name(bound)
                ));
            }
        }
    }

    /// Describes why a port of the current build is needed; `None` if it is not.
    fn describe_need(&self, index: usize, binding: &Binding) -> Option<String> {
        let variable = InstancePort::new(self.id, index);
        match binding {
            Binding::Import { source, .. } => {
                let source = self.application.source_name((*source)?);
                Some(format!("the application binds it to {source}"))
            }
            Binding::Actuator { target } => {
                let target = target.as_ref()?;
                Some(format!(
                    "the application binds it to {}",
                    self.application.variable_name(*target)
                ))
            }
            // The application file does not bind these: if a father no longer writes one, the child keeps its
            // value.
            Binding::ChildModulation { .. } => None,
            Binding::Export => self.reader(variable).or_else(|| {
                (self.application.mission == Some(variable)).then(|| "it is the mission".to_owned())
            }),
            Binding::Command => self.writer(variable),
            Binding::Modulation { set, .. } => {
                // The next start of the application would be refused, whatever the value.
                let set = || set.then(|| "the application sets it".to_owned());
                self.writer(variable)
                    .or_else(|| self.reader(variable))
                    .or_else(set)
            }
        }
    }

    fn reader(&self, variable: InstancePort) -> Option<String> {
        let reads = |binding: &Binding| matches!(binding, Binding::Import { source: Some(ImportSource::Local(port)), .. } if *port == variable);
        self.user(reads).map(|user| format!("{user} imports it"))
    }

    fn writer(&self, variable: InstancePort) -> Option<String> {
        let writes = |binding: &Binding| match binding {
            Binding::Actuator { target } => *target == Some(variable),
            Binding::ChildModulation {
                target: Some(ChildTarget::Port(port)),
            } => *port == variable,
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

    /// Returns the application's role of this name.
    fn map_role(&mut self, new: &Child) -> Option<RoleId> {
        let index = self.old().children.iter().position(|old| old.name == new.name);
        let role = index.map(RoleId::new);
        let bound = role.and_then(|role| self.instance().children[role]);
        match index {
            Some(index) => {
                let old = &self.old().children[index];
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
                "the child `{}` is new: no schema has its role until the application restarts",
                new.name
            )),
            None => {}
        }
        if bound.is_none() && !new.optional {
            self.errors.push(format!(
                "the child `{}` is not optional, and no schema has its role in the application",
                new.name
            ));
        }
        role
    }

    /// Returns the mapping of a port.
    fn map_port(&mut self, new: &Port) -> PortMapping {
        let index = self
            .old()
            .ports
            .iter()
            .position(|old| self.has_same_name(new, old));
        let Some(index) = index else {
            return self.map_new_port(new);
        };
        let instance = self.instance();
        let old = &instance.schema.ports[index];
        let name = self.port_name(new, &self.new.children);
        let unbound = matches!(
            instance.bindings[index],
            Binding::Import { source: None, .. }
                | Binding::Actuator { target: None }
                | Binding::ChildModulation { target: None }
        );
        if unbound && !new.has(raw::OPTIONAL) {
            self.errors.push(format!(
                "{name} is no longer optional, and the application leaves it unbound"
            ));
        }
        if !unbound {
            self.check_port(&name, old, new);
        }
        PortMapping::Bound(index)
    }

    /// Checks that a bound port has not changed.
    fn check_port(&mut self, name: &str, old: &Port, new: &Port) {
        if !old.value_type.same_as(&new.value_type) {
            let what = if old.value_type.name == new.value_type.name {
                "laid out differently".to_owned()
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
            (Role::Command { .. }, Role::Command { .. }) => self.note_change(
                [name, "a trigger; the application keeps its setting"],
                [old, new],
                raw::TRIGGER,
            ),
            (Role::Import, Role::Import) => self.note_change(
                [name, "a trigger by default; the application keeps its setting"],
                [old, new],
                raw::TRIGGER,
            ),
            (
                Role::Modulation { default, limits },
                Role::Modulation {
                    default: new_default,
                    limits: new_limits,
                },
            ) => {
                if default != new_default {
                    self.notes.push(format!(
                        "{name} has a new default; the running value is kept (`jde set` changes it)"
                    ));
                }
                let what = "read only on awakening; this takes effect when the application restarts";
                self.note_change([name, what], [old, new], raw::FIXED);
                if limits != new_limits {
                    self.notes.push(format!(
                        "{name} has new limits; the old ones apply until the application restarts"
                    ));
                }
            }
            _ => {}
        }
    }

    /// Notes that a port has an attribute now, or has it no longer.
    fn note_change(&mut self, [name, what]: [&str; 2], [old, new]: [&Port; 2], flag: u32) {
        if old.has(flag) != new.has(flag) {
            let now = if new.has(flag) { "now" } else { "no longer" };
            self.notes.push(format!("{name} is {now} {what}"));
        }
    }

    /// Returns the mapping of a port that the application does not have.
    fn map_new_port(&mut self, new: &Port) -> PortMapping {
        let name = self.port_name(new, &self.new.children);
        let mapping = match &new.role {
            Role::Import | Role::Actuator if !new.has(raw::OPTIONAL) => {
                self.errors.push(format!(
                    "{name} is new and not optional, and the application does not bind it"
                ));
                return PortMapping::Unbound;
            }
            Role::ChildModulation { child } => {
                let role = &self.new.children[*child].name;
                let old = self.old().children.iter().position(|old| old.name == *role);
                if !new.has(raw::OPTIONAL)
                    && old.is_some_and(|old| self.instance().children[RoleId::new(old)].is_some())
                {
                    self.errors.push(format!(
                        "{name} is new and not optional, and the application does not bind it"
                    ));
                }
                PortMapping::Unbound
            }
            Role::Import | Role::Actuator => PortMapping::Unbound,
            Role::Modulation { default, .. } => PortMapping::fixed(default, false),
            Role::Command { neutral, .. } => PortMapping::fixed(neutral, true),
            Role::Export { .. } => PortMapping::Discarded(new.value_type.bytes),
        };
        self.notes.push(match &mapping {
            PortMapping::Fixed { neutral: false, .. } => {
                format!("{name} is new: it has its default until the application restarts")
            }
            PortMapping::Fixed { neutral: true, .. } => {
                format!("{name} is new: no schema commands it until the application restarts")
            }
            PortMapping::Discarded(_) => {
                format!("{name} is new: no schema reads it until the application restarts")
            }
            PortMapping::Unbound | PortMapping::Bound(_) => {
                format!("{name} is new: it stays unbound until the application restarts")
            }
        });
        mapping
    }

    /// Whether two ports agree in kind, name and child. A former name is still read.
    fn has_same_name(&self, new: &Port, old: &Port) -> bool {
        let child = |port: &Port, children: &'a [Child]| match port.role {
            Role::ChildModulation { child } => Some(children[child].name.as_str()),
            Role::Import
            | Role::Export { .. }
            | Role::Modulation { .. }
            | Role::Command { .. }
            | Role::Actuator => None,
        };
        let is_renamed = new.former_name.as_deref() == Some(old.name.as_str());
        (new.name == old.name || is_renamed)
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

    fn schema_name(&self, id: SchemaId) -> String {
        self.application.instances[id].name.clone()
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
        Role::Import => "import",
        Role::Export { .. } => "export",
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
