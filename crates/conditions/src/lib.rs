//! temporary
#![allow(missing_docs, dead_code)]
mod check;
mod condition;
mod expression;
mod kind;
mod names;
mod view;
pub use condition::{BadCondition, Reason};
pub use expression::Expression;
pub use names::Names;
use std::collections::BTreeMap;
pub struct Signals {
    values: BTreeMap<String, Vec<u8>>,
    changed: Vec<String>,
    schemas: Vec<String>,
    time: f64,
}
impl Signals {
    pub fn new(names: &Names) -> Self {
        Self {
            values: BTreeMap::new(),
            changed: vec![],
            schemas: names.schemas.clone(),
            time: 0.0,
        }
    }
    fn put(&mut self, name: &str, bytes: Vec<u8>) {
        if self.values.get(name) != Some(&bytes) {
            self.values.insert(name.into(), bytes);
            self.changed.push(name.into());
        }
    }
    pub fn process_event(&mut self, e: &jde_records::event::Event) {
        if let jde_records::event::Event::StateChanged { schema, to, .. } = e {
            let n = format!("{}.won", self.schemas[*schema]);
            self.put(&n, vec![u8::from(*to == jde_core::State::Winner)]);
        }
    }
    pub fn process_value(&mut self, _v: &str, bytes: &[u8]) {
        use jde_types::Value as _;
        if let Some(t) = jde_types::Truth::from_bytes(bytes) {
            self.put("clearance", t.clearance.to_ne_bytes().to_vec());
            self.put("collisions", (t.collisions as f64).to_ne_bytes().to_vec());
        }
    }
    pub fn advance(&mut self, now: u64) {
        self.put("time", (now as f64 / 1e9).to_ne_bytes().to_vec());
    }
    pub fn changes(&mut self) -> impl Iterator<Item = (&str, &[u8])> {
        let c = std::mem::take(&mut self.changed);
        let mut c = c;
        c.sort();
        c.dedup();
        let v = &self.values;
        c.into_iter().map(move |n| {
            let (k, b) = v.get_key_value(&n).unwrap();
            (k.as_str(), b.as_slice())
        })
    }
}
