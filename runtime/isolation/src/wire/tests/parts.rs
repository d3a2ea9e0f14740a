//! Every message, of arbitrary parts.

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::path::PathBuf;
use std::sync::Arc;

use jde_abi::describe::{
    Attributes, Child, Field, FieldKind, Form, Guard, Kind, Limits, ListKind, Plugin, Port, PortList, Role,
    RosNotation, Schema, Type, Validity,
};
use jde_abi::lists::ListedPort;
use jde_abi::raw;
use jde_app::Isolation;
use jde_loader::PluginLocation;
use jde_loader::instance::{ArbitrationQuery, CandidateChild, Verdict};
use jde_panel::{Gesture, Touch};
use proptest::prelude::*;
use serde::Serialize;

use crate::TypeLocation;
use crate::inspect::{EntryPoint, InspectorRequest, InspectorResponse};
use crate::launch::{Acceptance, Launch, PortInfo};
use crate::messages::{
    Bytes, Call, Changes, Done, FromChild, Function, Input, Reply, Returned, Stamp, ToChild, Value,
};

/// What messages are made of.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    number: u32,
    word: u64,
    status: i32,
    float: f64,
    text: String,
    bytes: Vec<u8>,
}

impl Parts {
    pub(super) fn any() -> impl Strategy<Value = Self> {
        let bytes = proptest::collection::vec(any::<u8>(), 0..2000);
        (any::<(u32, u64, i32, f64, String)>(), bytes).prop_map(
            |((number, word, status, float, text), bytes)| Self {
                number,
                word,
                status,
                float,
                text,
                bytes,
            },
        )
    }

    /// A path that need not be text.
    fn path(&self) -> PathBuf {
        OsString::from_vec(self.bytes.clone()).into()
    }

    fn inputs(&self) -> [Result<Input<'_>, i32>; 4] {
        let stamp = Stamp {
            time_ns: self.word,
            sequence: !self.word,
            writer: self.number,
            flags: !self.number,
        };
        let input = |value| Ok(Input { stamp, value });
        [
            input(Value::Sent(Bytes(&self.bytes))),
            input(Value::InPlace(self.word as usize)),
            input(Value::Unchanged),
            Err(self.status),
        ]
    }

    /// A type that contains another.
    fn value_type(&self) -> Arc<Type> {
        let inner = Type {
            name: self.text.clone(),
            doc: String::new(),
            bytes: self.bytes.len(),
            align: 1,
            fields: Vec::new(),
        };
        let field = Field {
            name: String::from("inner"),
            doc: self.text.clone(),
            unit: String::from("m"),
            kind: FieldKind::Struct(inner.clone().into()),
            form: Form::One,
            offset: 0,
            notation: RosNotation::default(),
        };
        Arc::new(Type {
            fields: vec![field],
            ..inner
        })
    }

    pub(super) fn listed(&self) -> Vec<ListedPort> {
        vec![ListedPort {
            list: self.number as usize,
            label: self.text.clone(),
            value_type: self.value_type(),
            settings: self.bytes.clone(),
        }]
    }

    fn functions(&self) -> Vec<Function> {
        let launch = Launch {
            code: TypeLocation {
                plugin: PluginLocation::File(self.path()),
                number: self.number as usize,
            },
            name: self.text.clone(),
            application: self.word,
            seed: !self.word,
            real_time: true,
            ports: vec![PortInfo {
                writes: true,
                bytes: self.bytes.len(),
                memory: Some((self.word as usize, 3)),
                acceptance: Acceptance::IfFinite,
            }],
            listed: self.listed(),
            limits: Isolation::default(),
            authority: Some(self.number as usize),
        };
        let query = ArbitrationQuery {
            case: self.number,
            group: self.text.clone(),
            candidates: vec![CandidateChild {
                child: self.number,
                state: 2,
                ready: true,
                urgency: self.float,
            }],
            winner: None,
        };
        let gesture = Gesture {
            widget: self.text.clone(),
            touch: Touch::Pressed,
        };
        vec![
            Function::Start(Box::new(launch)),
            Function::Create,
            Function::Awake,
            Function::Check,
            Function::Iterate,
            Function::CheckAndIterate,
            Function::Arbitrate(query),
            Function::Sleep,
            Function::Draw,
            Function::Touch {
                by: self.text.clone(),
                gesture,
            },
            Function::Save,
            Function::Restore {
                version: self.number,
                memory: Bytes(self.bytes.clone()),
            },
        ]
    }

    pub(super) fn of_host(&self) -> Vec<ToChild<'_>> {
        let port = self.number;
        let place = self.word as usize;
        let mut messages = vec![ToChild::EarlyLoan { port, place }, ToChild::Destroy];
        for input in self.inputs() {
            messages.extend([
                ToChild::Early { port, input },
                ToChild::Reply(Reply::Input(input)),
            ]);
        }
        let replies = [
            Reply::Loan(Ok(None)),
            Reply::Loan(Ok(Some(self.word as usize))),
            Reply::Loan(Err(self.status)),
            Reply::Child(Ok((self.number, true))),
            Reply::Child(Err(self.status)),
            Reply::Status(self.status),
        ];
        messages.extend(replies.map(ToChild::Reply));
        for changes in [Changes::All, Changes::Answered, Changes::Nothing] {
            messages.extend(self.functions().into_iter().map(|function| {
                ToChild::Call(Call {
                    now: self.word,
                    machine: !self.word,
                    speed: self.float,
                    release: self.word / 2,
                    changes,
                    function,
                })
            }));
        }
        messages
    }

    pub(super) fn of_child(&self) -> Vec<FromChild<'_>> {
        let (port, child) = (self.number, self.number);
        let mut messages = vec![
            FromChild::Read { port },
            FromChild::Loan { port },
            FromChild::Publish {
                port,
                time: self.word,
                value: None,
                unanswered: true,
            },
            FromChild::Publish {
                port,
                time: self.word,
                value: Some(Bytes(&self.bytes)),
                unanswered: false,
            },
            FromChild::Retract {
                port,
                unanswered: true,
            },
            FromChild::Wake { child },
            FromChild::PutToSleep { child },
            FromChild::Child { child },
            FromChild::SetPolicy {
                child,
                policy: self.number,
                dwell_ns: self.word,
                hysteresis: self.float,
            },
            FromChild::Hold(true),
            FromChild::Log {
                level: self.number,
                text: &self.text,
            },
            FromChild::Fail(&self.text),
        ];
        let verdict = Verdict {
            child: Some(self.number),
            reason: self.text.clone(),
        };
        let outcomes = [
            Returned::Nothing,
            Returned::Started(vec![self.text.clone(); 3]),
            Returned::Refused(self.text.clone()),
            Returned::Checked {
                ready: true,
                urgency: self.float,
            },
            Returned::Arbitrated(verdict),
            Returned::Drawn(Bytes(self.bytes.clone())),
            Returned::Saved(Ok(Bytes(self.bytes.clone()))),
            Returned::Saved(Err(self.text.clone())),
        ];
        messages.extend(outcomes.map(|outcome| {
            FromChild::Done(Done {
                status: self.status,
                read_early: u128::from(self.word) << 64 | 1,
                first_time: Some(self.word),
                outcome,
            })
        }));
        messages
    }

    pub(super) fn inspections(&self) -> Vec<InspectorRequest> {
        vec![
            InspectorRequest::Describe {
                copy: self.path(),
                path: self.path(),
            },
            InspectorRequest::EntryPoints,
            InspectorRequest::Inspect {
                path: self.path(),
                number: self.number as usize,
                name: self.text.clone(),
                listed: self.listed(),
            },
        ]
    }

    fn plugin(&self) -> Plugin {
        let validity = Validity::Time(self.word);
        let roles = [
            Role::Import,
            Role::Export { validity },
            Role::Modulation {
                default: self.bytes.clone(),
                limits: Limits {
                    least: Some(self.float),
                    greatest: None,
                    choices: vec![self.text.clone()],
                },
            },
            Role::Command {
                neutral: self.bytes.clone(),
                validity_ns: self.word,
            },
            Role::Actuator,
            Role::ChildModulation { child: 3 },
        ];
        let port = |role| Port {
            name: self.text.clone(),
            doc: self.text.clone(),
            unit: String::from("m"),
            value_type: self.value_type(),
            role,
            attributes: Attributes::of(raw::IMPORT, raw::OPTIONAL),
            former_name: Some(self.text.clone()),
        };
        let child = Child {
            name: self.text.clone(),
            doc: self.text.clone(),
            motor: true,
            group: self.text.clone(),
            optional: false,
            many: true,
        };
        let list = |kind| PortList {
            name: self.text.clone(),
            doc: self.text.clone(),
            kind,
            settings: self.value_type(),
            initial: self.bytes.clone(),
        };
        let kinds = [
            ListKind::Imports,
            ListKind::Exports { validity },
            ListKind::Commands {
                validity_ns: self.word,
            },
        ];
        let schema = Schema {
            name: self.text.clone(),
            doc: self.text.clone(),
            kind: Kind::Driver,
            period_ns: self.word,
            budget_ns: Some(self.word),
            ports: roles.map(port).to_vec(),
            children: vec![child],
            arbitrates: true,
            panel: false,
            touch: false,
            memory: true,
            inspects: true,
            guard: Some(Guard {
                state: self.number as usize,
                command: self.value_type(),
            }),
            lists: kinds.map(list).to_vec(),
        };
        Plugin {
            name: self.text.clone(),
            version: self.text.clone(),
            doc: self.text.clone(),
            abi: (self.number, 2),
            throws: true,
            isolated: false,
            schemas: vec![schema],
        }
    }

    pub(super) fn inspected(&self) -> Vec<InspectorResponse> {
        vec![
            InspectorResponse::Plugin(self.plugin()),
            InspectorResponse::EntryPoints(vec![EntryPoint(self.text.clone(), self.path())]),
            InspectorResponse::Inspected {
                status: self.status,
                found: Ok(vec![(true, self.number, self.text.clone())]),
            },
            InspectorResponse::Inspected {
                status: self.status,
                found: Err(self.text.clone()),
            },
            InspectorResponse::Refused(self.text.clone()),
        ]
    }

    /// The encoded messages.
    pub(super) fn encoded(&self) -> Vec<Vec<u8>> {
        fn encode(message: &impl Serialize) -> Vec<u8> {
            let mut wire = super::pair().0;
            wire.queue(message);
            wire.output
        }
        let mut encoded: Vec<_> = self.of_host().iter().map(encode).collect();
        encoded.extend(self.of_child().iter().map(encode));
        encoded.extend(self.inspections().iter().map(encode));
        encoded.extend(self.inspected().iter().map(encode));
        encoded
    }
}
