//! The parameters of the node: each modulation, a structure field by field. A list of structures is none. As of every node
//! of ROS 2, one is `use_sim_time`.
//!
//! A parameter that is set is a modulation by an operator (R14), within the limits of its type (R8).

use std::collections::BTreeSet;
use std::time::Instant;

use jde_abi::describe::{FieldKind, Form, Limits, Scalar, Type};
use jde_board::value::decode;
use jde_board::{Access, Reader};
use jde_link::message::Action;
use jde_link::{Subject as _, TokenBucket, value};
use jde_link_host::Running;
use serde_json::{Value, json};

use super::OPERATOR;
use super::reports::stamp;
use super::sim_time::{SIM_TIME, SimTime};

/// Numbers of types in `rcl_interfaces/msg/ParameterType`.
const NOT_SET: usize = 0;
pub(super) const BOOL: usize = 1;
const INTEGER: usize = 2;
const DOUBLE: usize = 3;
const STRING: usize = 4;
/// What is added to the type of a number for a list of it.
const ARRAY: usize = 5;

/// The names of these types, and the fields of a value that have them.
const TYPES: [(&str, &str); 9] = [
    ("nothing", ""),
    ("a bool", "bool_value"),
    ("an integer", "integer_value"),
    ("a double", "double_value"),
    ("a text", "string_value"),
    ("a list of bytes", "byte_array_value"),
    ("a list of bools", "bool_array_value"),
    ("a list of integers", "integer_array_value"),
    ("a list of doubles", "double_array_value"),
];

/// Why a parameter is not set that exceeds the rate.
const TOO_MANY: &str = "more than 100 parameters are set in a second: it keeps its value; set it again later";

/// The parameters, in the order of the application.
pub(super) struct Parameters {
    sim_time: SimTime,
    /// Its value in the last event.
    published_sim_time: Option<bool>,
    parameters: Vec<Parameter>,
    modulations: Vec<Modulation>,
}

struct Modulation {
    reader: Reader,
    fixed: bool,
    /// The number of the value that the last event considered.
    considered: Option<u64>,
}

struct Parameter {
    name: String,
    kind: usize,
    /// The fields that lead to it within the modulation.
    path: Vec<String>,
    /// The modulation's place.
    modulation: usize,
    /// Its value in the last event.
    published: Option<Value>,
}

impl Modulation {
    /// Whether it was written since the last call.
    fn is_written(&mut self) -> bool {
        let newest = Some(self.reader.newest());
        std::mem::replace(&mut self.considered, newest) != newest
    }
}

impl Parameters {
    pub(super) fn new(subject: &Running, sim_time: SimTime) -> Self {
        let mut this = Self {
            sim_time,
            published_sim_time: None,
            parameters: Vec::new(),
            modulations: Vec::new(),
        };
        for variable in subject.board().list() {
            let declared = variable.describe();
            if declared.access != Access::Modulation {
                continue;
            }
            let modulation = this.modulations.len();
            this.modulations.push(Modulation {
                reader: variable.reader(OPERATOR),
                fixed: subject.is_fixed(&variable),
                considered: None,
            });
            let leaves = leaves(&declared.value_type);
            this.parameters
                .extend(leaves.into_iter().map(|(path, kind)| Parameter {
                    name: [&[declared.full_name()][..], &path[..]].concat().join("."),
                    kind,
                    path,
                    modulation,
                    published: None,
                }));
        }
        this
    }

    /// The response to `list_parameters`.
    pub(super) fn list(&self, request: &Value) -> Value {
        let prefixes = texts(&request["prefixes"]);
        let depth = request["depth"].as_u64().unwrap_or_default();
        let is_near = |rest: &str| depth == 0 || (rest.matches('.').count() as u64) < depth;
        let is_listed = |name: &&str| {
            let within = |prefix: &&str| {
                let rest = name.strip_prefix(*prefix)?;
                (rest.is_empty() || rest.strip_prefix('.').is_some_and(is_near)).then_some(())
            };
            let mut prefixes = prefixes.iter();
            if prefixes.len() == 0 {
                is_near(name)
            } else {
                prefixes.any(|prefix| within(prefix).is_some())
            }
        };
        let names: Vec<_> = self.names().filter(is_listed).collect();
        let before = names
            .iter()
            .filter_map(|name| name.rsplit_once('.').map(|(before, _)| before));
        json!({ "result": { "prefixes": before.collect::<BTreeSet<_>>(), "names": names } })
    }

    /// The response to `get_parameters`. An unknown parameter is not set.
    pub(super) fn get(&mut self, request: &Value) -> Value {
        let names = texts(&request["names"]);
        let values: Vec<_> = names
            .iter()
            .map(|name| self.value_of(name).unwrap_or_else(|| json!({ "type": NOT_SET })))
            .collect();
        json!({ "values": values })
    }

    /// The response to `get_parameter_types`.
    pub(super) fn types(&self, request: &Value) -> Value {
        let kind = |name: &&str| match self.find(name) {
            _ if *name == SIM_TIME => BOOL,
            Some(place) => self.parameters[place].kind,
            None => NOT_SET,
        };
        json!({ "types": texts(&request["names"]).iter().map(kind).collect::<Vec<_>>() })
    }

    /// The response to `describe_parameters`.
    pub(super) fn describe(&self, request: &Value) -> Value {
        let describe = |name: &&str| match self.find(name) {
            _ if *name == SIM_TIME => SimTime::descriptor(),
            Some(place) => self.descriptor(&self.parameters[place]),
            None => json!({ "name": name, "type": NOT_SET }),
        };
        json!({ "descriptors": texts(&request["names"]).iter().map(describe).collect::<Vec<_>>() })
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Sets parameters one by one, as many as `limit` permits, and returns the response to `set_parameters`.
    pub(super) fn set(&mut self, subject: &Running, limit: &mut TokenBucket, request: &Value) -> Value {
        let parameters = request["parameters"].as_array().into_iter().flatten();
        let results = parameters.map(|parameter| {
            let is_allowed = limit.try_take(Instant::now());
            result(match is_allowed {
                true => self.set_one(subject, parameter),
                false => Err(TOO_MANY.to_owned()),
            })
        });
        json!({ "results": results.collect::<Vec<_>>() })
    }

    /// Sets all parameters or none, and returns the response to `set_parameters_atomically`. If one is refused,
    /// those before it have their values again. `limit` permits all or none.
    pub(super) fn set_atomically(
        &mut self,
        subject: &Running,
        limit: &mut TokenBucket,
        request: &Value,
    ) -> Value {
        let count = request["parameters"].as_array().map_or(0, Vec::len);
        if !limit.try_take_all(count, Instant::now()) {
            return json!({ "result": result(Err(TOO_MANY.to_owned())) });
        }
        let mut before = Vec::new();
        let mut outcome = Ok(());
        for parameter in request["parameters"].as_array().into_iter().flatten() {
            let name = parameter["name"].as_str().unwrap_or_default();
            let old = self.value_of(name);
            outcome = self.set_one(subject, parameter);
            if outcome.is_err() {
                break;
            }
            before.push(json!({ "name": name, "value": old }));
        }
        if outcome.is_err() {
            for old in before.iter().rev() {
                if let Err(reason) = self.set_one(subject, old) {
                    tracing::warn!("ROS 2: {} keeps its new value: {reason}", old["name"]);
                }
            }
        }
        json!({ "result": result(outcome) })
    }

    /// Returns the event of the values that changed since the last call.
    pub(super) fn event(&mut self, node: &str) -> Option<Value> {
        let is_written: Vec<bool> = self.modulations.iter_mut().map(Modulation::is_written).collect();
        let (mut new, mut changed) = (Vec::new(), Vec::new());
        let sim_time = self.sim_time.is_simulated;
        let entry = json!({ "name": SIM_TIME, "value": self.sim_time.value() });
        match self.published_sim_time.replace(sim_time) {
            None => new.push(entry),
            Some(old) if old != sim_time => changed.push(entry),
            Some(_) => {}
        }
        for place in 0..self.parameters.len() {
            if !is_written[self.parameters[place].modulation] {
                continue;
            }
            let value = self.value(place);
            let parameter = &mut self.parameters[place];
            let old = parameter.published.replace(value.clone());
            let entry = json!({ "name": parameter.name, "value": value });
            match old {
                None => new.push(entry),
                Some(old) if old != value => changed.push(entry),
                Some(_) => {}
            }
        }
        if new.is_empty() && changed.is_empty() {
            return None;
        }
        Some(json!({
            "stamp": stamp(),
            "node": node,
            "new_parameters": new,
            "changed_parameters": changed,
        }))
    }

    /// The names of all parameters.
    fn names(&self) -> impl Iterator<Item = &str> {
        let modulations = self.parameters.iter().map(|parameter| parameter.name.as_str());
        std::iter::once(SIM_TIME).chain(modulations)
    }

    /// Returns the present value of the parameter of that name, if there is one.
    fn value_of(&mut self, name: &str) -> Option<Value> {
        if name == SIM_TIME {
            return Some(self.sim_time.value());
        }
        self.find(name).map(|place| self.value(place))
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.parameters
            .iter()
            .position(|parameter| parameter.name == name)
    }

    /// Returns the present value. One that a parameter cannot have, such as NaN, is not set.
    fn value(&mut self, place: usize) -> Value {
        let Parameter {
            kind,
            path,
            modulation,
            ..
        } = &self.parameters[place];
        let reader = &mut self.modulations[*modulation].reader;
        let value_type = reader.variable().describe().value_type.clone();
        let Some(latched) = reader.latch_newest(0) else {
            return json!({ "type": NOT_SET });
        };
        let mut json = value::to_json(&decode(&value_type, latched.bytes).into_only_field());
        for field in path {
            json = json.get_mut(field).map(Value::take).unwrap_or_default();
        }
        if is_of(*kind, &json) {
            json!({ "type": kind, TYPES[*kind].1: json })
        } else {
            json!({ "type": NOT_SET })
        }
    }

    fn descriptor(&self, parameter: &Parameter) -> Value {
        let modulation = &self.modulations[parameter.modulation];
        let declared = modulation.reader.variable().describe();
        let unit = match declared.unit.as_str() {
            "" => String::new(),
            unit => format!(" [{unit}]"),
        };
        let mut constraints = Vec::new();
        if !declared.limits.choices.is_empty() {
            constraints.push(format!("from 0 on: {}", declared.limits.choices.join(", ")));
        }
        if modulation.fixed {
            constraints.push("read when the schema awakes".to_owned());
        }
        let mut descriptor = json!({
            "name": parameter.name,
            "type": parameter.kind,
            "description": format!("{}{unit}", declared.doc),
            "additional_constraints": constraints.join("; "),
        });
        if let Some((field, range)) = range(parameter.kind, &declared.limits) {
            descriptor[field] = json!([range]);
        }
        descriptor
    }

    fn set_one(&mut self, subject: &Running, parameter: &Value) -> Result<(), String> {
        let name = parameter["name"].as_str().unwrap_or_default();
        if name == SIM_TIME {
            return self.sim_time.set(subject, &parameter["value"]);
        }
        let place = self
            .find(name)
            .ok_or_else(|| match jde_nearest::nearest(name, self.names()) {
                Some(near) => format!("there is no parameter `{name}`; did you mean `{near}`?"),
                None => format!("there is no parameter `{name}`"),
            })?;
        let Parameter {
            kind,
            path,
            modulation,
            ..
        } = &self.parameters[place];
        let given = parameter["value"]["type"].as_u64().unwrap_or_default();
        let given = usize::try_from(given).unwrap_or(TYPES.len());
        // A number without a point is an integer to the tools of ROS 2.
        let is_number = [(INTEGER, DOUBLE), (INTEGER + ARRAY, DOUBLE + ARRAY)].contains(&(given, *kind));
        if given != *kind && !is_number {
            let given = TYPES.get(given).map_or("a list of texts", |(name, _)| name);
            return Err(format!("`{name}` is {}, not {given}", TYPES[*kind].0));
        }
        let new = parameter["value"][TYPES[given].1].clone();
        let new = path
            .iter()
            .rev()
            .fold(new, |inner, field| json!({ field: inner }));
        let declared = self.modulations[*modulation].reader.variable().describe();
        let action = Action::Modulate {
            schema: declared.owner.clone(),
            variable: declared.name.clone(),
            value: new,
        };
        subject.act(OPERATOR, &action).map_err(|refusal| refusal.error)
    }
}

/// Returns the fields of a type that are parameters: the way to each, and its type. A structure with one field
/// is that field.
fn leaves(value_type: &Type) -> Vec<(Vec<String>, usize)> {
    let mut leaves = Vec::new();
    collect(value_type, &mut Vec::new(), &mut leaves);
    if value_type.fields.len() == 1 {
        leaves.iter_mut().for_each(|(path, _)| drop(path.remove(0)));
    }
    leaves
}

fn collect(value_type: &Type, path: &mut Vec<String>, leaves: &mut Vec<(Vec<String>, usize)>) {
    for field in &value_type.fields {
        path.push(field.name.clone());
        match (&field.kind, &field.form) {
            (FieldKind::Struct(inner), Form::One) => collect(inner, path, leaves),
            (FieldKind::Struct(_), _) => {}
            (FieldKind::Scalar(_), Form::Text { .. }) => leaves.push((path.clone(), STRING)),
            (FieldKind::Scalar(scalar), form) => {
                let kind = match scalar {
                    Scalar::Bool => BOOL,
                    Scalar::F32 | Scalar::F64 => DOUBLE,
                    _ => INTEGER,
                };
                let list = if matches!(form, Form::One) { 0 } else { ARRAY };
                leaves.push((path.clone(), kind + list));
            }
        }
        path.pop();
    }
}

/// Returns the range of a number with limits, and the field of a descriptor that has it.
fn range(kind: usize, limits: &Limits) -> Option<(&'static str, Value)> {
    limits.least.or(limits.greatest)?;
    match kind {
        DOUBLE => {
            let (least, greatest) = (
                limits.least.unwrap_or(f64::MIN),
                limits.greatest.unwrap_or(f64::MAX),
            );
            let range = json!({ "from_value": least, "to_value": greatest });
            Some(("floating_point_range", range))
        }
        INTEGER => {
            let least = limits.least.map_or(i64::MIN, |least| least.ceil() as i64);
            let greatest = limits
                .greatest
                .map_or(i64::MAX, |greatest| greatest.floor() as i64);
            Some((
                "integer_range",
                json!({ "from_value": least, "to_value": greatest, "step": 1 }),
            ))
        }
        _ => None,
    }
}

/// Whether a value is of that type.
fn is_of(kind: usize, value: &Value) -> bool {
    match kind {
        BOOL => value.is_boolean(),
        INTEGER => value.is_i64(),
        DOUBLE => value.is_number(),
        STRING => value.is_string(),
        list => value
            .as_array()
            .is_some_and(|elements| elements.iter().all(|element| is_of(list - ARRAY, element))),
    }
}

fn result(outcome: Result<(), String>) -> Value {
    json!({ "successful": outcome.is_ok(), "reason": outcome.err().unwrap_or_default() })
}

fn texts(list: &Value) -> Vec<&str> {
    list.as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
        .collect()
}

#[cfg(test)]
mod tests {
    use jde_types::{Flag, Pose2D, Twist, Value as _};

    use super::*;

    #[test]
    fn a_structure_is_flattened_and_a_number_is_itself() {
        let names = |value_type: &Type| {
            let leaves = leaves(value_type).into_iter();
            leaves
                .map(|(path, kind)| (path.join("."), kind))
                .collect::<Vec<_>>()
        };
        assert_eq!(names(&f64::describe()), [(String::new(), DOUBLE)]);
        assert_eq!(names(&Flag::describe()), [(String::new(), BOOL)]);
        assert_eq!(names(&<[i32; 3]>::describe()), [(String::new(), INTEGER + ARRAY)]);
        let pose = names(&Pose2D::describe());
        assert_eq!(pose[2], ("theta".to_owned(), DOUBLE));
        assert_eq!(names(&Twist::describe())[5], ("angular.z".to_owned(), DOUBLE));
    }

    #[test]
    fn limits_are_the_range_of_their_type() {
        let limits = Limits {
            least: Some(0.5),
            greatest: None,
            choices: Vec::new(),
        };
        let (field, double) = range(DOUBLE, &limits).unwrap();
        assert_eq!(
            (field, &double["from_value"]),
            ("floating_point_range", &json!(0.5))
        );
        let (field, integer) = range(INTEGER, &limits).unwrap();
        assert_eq!((field, &integer["from_value"]), ("integer_range", &json!(1)));
        assert_eq!(integer["to_value"], json!(i64::MAX));
        assert!(range(DOUBLE, &Limits::default()).is_none());
        assert!(range(STRING, &limits).is_none());
    }
}
