//! The application as a node of ROS 2: its modulations are parameters, its operators' requests are services, and
//! its log and health are topics. A thread of normal priority serves it, at most 100 requests of at most 64 KiB
//! per second, because it takes the engine's lock. Of what they set, 100 parameters per second are accepted. `stop` has a thread
//! of its own. No schema waits for them.

mod lifecycle;
mod parameters;
mod reports;
mod sim_time;
mod stopper;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use jde_host::{Handle, StartHook, StartHookError};
use jde_link::message::Action;
use jde_link::{Subject as _, SubjectInfo, TokenBucket};
use jde_link_host::Running;
use jde_loader::Plugins;
use jde_records::event::{Event, Observer};
use jde_ros_node::interface::standard;
use jde_ros_node::{
    Node, NodeConfig, NodeName, NodeState, Quality, Remaps, Request, Service, Topic, environment_connection,
    environment_domain, environment_middleware, names,
};
use jde_session::log::{Log, LogRecord};
use jde_session::run::{Extension, PreparedExtension, RecordingSummary, RunContext};
use parking_lot::Mutex;
use serde_json::{Value, json};

use crate::failure::Failure;
use lifecycle::Lifecycle;
use parameters::Parameters;

pub(super) use reports::severity;
pub(crate) use sim_time::{CLOCK, SIM_TIME, SimTime};

/// The operator's name of what is requested over ROS 2 (R14).
const OPERATOR: &str = "ros2";
/// The shortest time between two requests that are answered. It is as long as the first one took, if that is longer, so that
/// requests take at most half of a processor.
const REQUEST_INTERVAL: Duration = Duration::from_millis(10);
/// Parameters that are set per second: each is an action of an operator, which takes the engine's lock and is recorded.
const SETTINGS_PER_SECOND: f64 = 100.0;
/// The greatest size of a request, bytes.
const MAX_REQUEST: usize = 1 << 16;
/// How often changes are published.
const CHANGE_INTERVAL: Duration = Duration::from_millis(100);
/// How often the health is published.
const DIAGNOSTICS_INTERVAL: Duration = Duration::from_secs(1);
/// Most lines of the log that wait; further ones are dropped.
const MAX_LINES: usize = 256;

/// The place of `stop` in [`SERVICES`].
const STOP_SERVICE: usize = 11;

/// The services below the node's own name, and their types.
const SERVICES: [(&str, &str); 15] = [
    ("list_parameters", "rcl_interfaces/srv/ListParameters"),
    ("get_parameters", "rcl_interfaces/srv/GetParameters"),
    ("get_parameter_types", "rcl_interfaces/srv/GetParameterTypes"),
    ("describe_parameters", "rcl_interfaces/srv/DescribeParameters"),
    ("set_parameters", "rcl_interfaces/srv/SetParameters"),
    (
        "set_parameters_atomically",
        "rcl_interfaces/srv/SetParametersAtomically",
    ),
    ("get_state", "lifecycle_msgs/srv/GetState"),
    ("change_state", "lifecycle_msgs/srv/ChangeState"),
    ("get_available_states", "lifecycle_msgs/srv/GetAvailableStates"),
    (
        "get_available_transitions",
        "lifecycle_msgs/srv/GetAvailableTransitions",
    ),
    (
        "get_transition_graph",
        "lifecycle_msgs/srv/GetAvailableTransitions",
    ),
    ("stop", "std_srvs/srv/Trigger"),
    ("release", "std_srvs/srv/Trigger"),
    ("enable", "std_srvs/srv/SetBool"),
    (
        "get_type_description",
        "type_description_interfaces/srv/GetTypeDescription",
    ),
];

/// A topic that the node publishes.
#[derive(Clone, Copy)]
enum Publication {
    Log,
    ParameterEvents,
    Diagnostics,
    TransitionEvent,
    Bond,
}

/// The topics in the order of [`Publication`]: name, type and quality. A name with `~` is below the node's own.
const TOPICS: [(&str, &str, Quality); 5] = [
    ("/rosout", "rcl_interfaces/msg/Log", Quality::LOG),
    (
        "/parameter_events",
        "rcl_interfaces/msg/ParameterEvent",
        Quality::PARAMETERS,
    ),
    (
        "/diagnostics",
        "diagnostic_msgs/msg/DiagnosticArray",
        Quality::DEFAULT,
    ),
    (
        "~/transition_event",
        "lifecycle_msgs/msg/TransitionEvent",
        Quality::DEFAULT,
    ),
    ("bond", "bond/msg/Status", Quality::DEFAULT),
];

/// Makes the application a node.
pub(crate) struct RosOptions {
    /// Its names, and other names of its topics and services.
    pub(crate) remaps: Remaps,
    /// The clock of its drivers.
    pub(crate) sim_time: SimTime,
    /// The log that is published.
    pub(crate) log: Log,
}

/// The node of a run.
struct RunNode {
    config: NodeConfig,
    info: SubjectInfo,
    sim_time: SimTime,
    log: Log,
    stop: Arc<AtomicBool>,
    thread: Arc<Mutex<Option<JoinHandle<()>>>>,
}

impl Extension for RosOptions {
    fn prepare(
        &self,
        context: &RunContext<'_>,
    ) -> Result<Option<Box<dyn PreparedExtension>>, StartHookError> {
        if context.lockstep {
            return Err(Failure::usage(
                "a node of ROS 2 needs real time",
                "run it without --lockstep, or without --ros-args",
            )
            .into());
        }
        let config = self.config(&context.application.name).map_err(|error| {
            Failure::usage(
                error,
                "the names of the node follow --ros-args; its domain and router are in the environment",
            )
        })?;
        Ok(Some(Box::new(RunNode {
            config,
            info: SubjectInfo::new(context.application, context.speed),
            sim_time: self.sim_time.clone(),
            log: self.log.clone(),
            stop: Arc::default(),
            thread: Arc::default(),
        })))
    }
}

/// Returns the name that an application has as a node.
///
/// # Errors
/// The environment's domain is not valid.
pub(crate) fn node_name(remaps: &Remaps, application: &str) -> Result<NodeName, String> {
    let own = names::node("", application)?;
    let node = remaps.node(&own).unwrap_or(&own).to_owned();
    let namespace = remaps.namespace(&node).map(|(namespace, _)| namespace.to_owned());
    Ok(NodeName {
        domain: names::domain(-1, environment_domain().as_deref())?,
        namespace: namespace.unwrap_or_default(),
        node,
        middleware: environment_middleware(),
    })
}

impl RosOptions {
    fn config(&self, application: &str) -> Result<NodeConfig, String> {
        let name = node_name(&self.remaps, application)?;
        let own = name.full();
        let unknown = |kind: &str| format!("{kind} is not a standard interface");
        let topics = TOPICS.iter().map(|(topic, kind, quality)| {
            let topic = names::topic(&name.namespace, &topic.replace('~', &own))?.unwrap_or_default();
            Topic::of_interface(topic, kind, standard(), *quality).ok_or_else(|| unknown(kind))
        });
        let services = SERVICES.iter().map(|(name, kind)| {
            Service::new(format!("{own}/{name}"), kind, standard()).ok_or_else(|| unknown(kind))
        });
        Ok(NodeConfig {
            publications: topics.collect::<Result<_, _>>()?,
            services: services.collect::<Result<_, _>>()?,
            urgent_service: Some(STOP_SERVICE),
            remaps: self.remaps.clone(),
            ..NodeConfig::new(name, environment_connection()?)
        })
    }
}

impl PreparedExtension for RunNode {
    fn observer(&self) -> Box<dyn Observer> {
        Box::new(|_: &Event| {})
    }

    /// The hook starts the node and the thread that serves it.
    fn before_start(&self, _: &Arc<Plugins>) -> StartHook {
        let (config, info, sim_time) = (self.config.clone(), self.info.clone(), self.sim_time.clone());
        let (stop, thread, log) = (Arc::clone(&self.stop), Arc::clone(&self.thread), self.log.clone());
        Box::new(move |handle: &Handle| {
            let (sender, lines) = sync_channel(MAX_LINES);
            log.forward(sender);
            let server = Server::new(handle.clone(), (info, sim_time), config, lines)?;
            let serve = std::thread::Builder::new()
                .name("ros-node".to_owned())
                .spawn(move || server.run(&stop))?;
            *thread.lock() = Some(serve);
            Ok(())
        })
    }

    fn finish(&self) -> Option<RecordingSummary> {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.lock().take() {
            let _ = thread.join();
        }
        None
    }
}

/// Serves the node until the run ends.
struct Server {
    handle: Handle,
    subject: Arc<Running>,
    node: Arc<Node>,
    name: NodeName,
    parameters: Parameters,
    lifecycle: Lifecycle,
    /// How many parameters may be set now.
    settings: TokenBucket,
    lines: Receiver<LogRecord>,
    /// Whether the log says that the node is not connected.
    is_lost: bool,
}

impl Server {
    fn new(
        handle: Handle,
        (info, sim_time): (SubjectInfo, SimTime),
        config: NodeConfig,
        lines: Receiver<LogRecord>,
    ) -> std::io::Result<Self> {
        let subject = Arc::new(Running::new(handle.clone(), info));
        let parameters = Parameters::new(&subject, sim_time);
        // A file of all parameters is loaded at once.
        let burst = SETTINGS_PER_SECOND.max(parameters.len() as f64);
        Ok(Self {
            parameters,
            settings: TokenBucket::with_burst(SETTINGS_PER_SECOND, burst, Instant::now()),
            lifecycle: Lifecycle::new(&subject),
            name: config.name.clone(),
            node: Arc::new(Node::start(config)?),
            handle,
            subject,
            lines,
            is_lost: false,
        })
    }

    /// Serves the node until `end`.
    fn run(mut self, end: &AtomicBool) {
        let (node, subject) = (Arc::clone(&self.node), Arc::clone(&self.subject));
        std::thread::scope(|scope| {
            let stopper = std::thread::Builder::new()
                .name("ros-stop".to_owned())
                .spawn_scoped(scope, || stopper::run(&node, &subject, end));
            if let Err(error) = stopper {
                tracing::error!("ROS 2: there is no thread to stop everything: {error}");
            }
            self.serve(end);
        });
        self.node.close();
    }

    fn serve(&mut self, stop: &AtomicBool) {
        let mut next_request = Instant::now();
        let (mut next_change, mut next_diagnostics) = (next_request, next_request);
        while !stop.load(Ordering::Relaxed) {
            let now = Instant::now();
            if now < next_request {
                std::thread::sleep(next_request - now);
            } else if let Some(request) = self.node.take_request(next_change.saturating_duration_since(now)) {
                let begun = Instant::now();
                self.answer(request);
                let ended = Instant::now();
                next_request = (begun + REQUEST_INTERVAL).max(ended + (ended - begun));
            }
            let now = Instant::now();
            if now >= next_change {
                next_change = now + CHANGE_INTERVAL;
                self.publish_changes();
            }
            if now >= next_diagnostics {
                next_diagnostics = now + DIAGNOSTICS_INTERVAL;
                let health = reports::diagnostics(&self.name, &self.subject);
                self.publish(Publication::Diagnostics, &health);
            }
        }
        // What was said at the end is sent, too.
        self.lifecycle.finalize();
        self.publish_changes();
    }

    fn publish(&self, publication: Publication, value: &Value) {
        let number = publication as usize;
        match standard().encode(TOPICS[number].1, value) {
            Ok(message) => self.node.append(number, message),
            Err(error) => tracing::debug!("{}: {error}", TOPICS[number].0),
        }
    }

    fn publish_log(&self) {
        for line in self.lines.try_iter() {
            self.publish(Publication::Log, &reports::log(&self.name, &line));
        }
    }

    fn publish_changes(&mut self) {
        self.report_connection();
        self.publish_log();
        if let Some(event) = self.parameters.event(&self.name.full()) {
            self.publish(Publication::ParameterEvents, &event);
        }
        self.publish_transitions();
        if let Some(heartbeat) = self.lifecycle.heartbeat(&self.subject, &self.name.node) {
            self.publish(Publication::Bond, &heartbeat);
        }
    }

    fn publish_transitions(&mut self) {
        for event in self.lifecycle.events(&self.subject) {
            self.publish(Publication::TransitionEvent, &event);
        }
    }

    /// Logs once that the node is not connected, and once that it is.
    fn report_connection(&mut self) {
        for remark in self.node.remarks() {
            tracing::warn!("ROS 2: {remark}");
        }
        match self.node.state().0 {
            NodeState::Lost(reason) if !self.is_lost => {
                self.is_lost = true;
                tracing::warn!("ROS 2: {reason}; the node tries again");
            }
            NodeState::Connected => {
                if std::mem::take(&mut self.is_lost) {
                    tracing::warn!("ROS 2: the node {} is connected", self.name.full());
                }
            }
            NodeState::Lost(_) | NodeState::Connecting | NodeState::Alone => {}
        }
    }

    /// Answers a request. One that is no message of its type has no response.
    fn answer(&mut self, request: Request) {
        let (name, kind) = SERVICES[request.service];
        let size = request.message().len();
        if size > MAX_REQUEST {
            tracing::warn!(
                "ROS 2: a request to {name} is ignored: it has {size} bytes, and {MAX_REQUEST} may be"
            );
            return;
        }
        let response = standard()
            .decode(&format!("{kind}_Request"), &request.message())
            .map(|message| self.respond(name, &message))
            .and_then(|response| standard().encode(&format!("{kind}_Response"), &response));
        // Each change has its event, before the response as in ROS 2.
        self.publish_transitions();
        match response {
            Ok(message) => self.node.reply(request, message),
            Err(error) => tracing::warn!("ROS 2: a request to {name} is ignored: {error}"),
        }
    }

    fn respond(&mut self, service: &str, request: &Value) -> Value {
        match service {
            "list_parameters" => self.parameters.list(request),
            "get_parameters" => self.parameters.get(request),
            "get_parameter_types" => self.parameters.types(request),
            "describe_parameters" => self.parameters.describe(request),
            "set_parameters" => self.parameters.set(&self.subject, &mut self.settings, request),
            "set_parameters_atomically" => {
                self.parameters
                    .set_atomically(&self.subject, &mut self.settings, request)
            }
            "get_state" => self.lifecycle.state(&self.subject),
            "change_state" => self.lifecycle.change(&self.subject, &self.handle, request),
            "get_available_states" => lifecycle::states(),
            "get_available_transitions" => self.lifecycle.available(&self.subject),
            "get_transition_graph" => lifecycle::graph(),
            "get_type_description" => describe_type(request),
            "enable" if request["data"] == true => act(&self.subject, &Action::ReleaseAll),
            "stop" | "enable" => act(&self.subject, &Action::StopAll),
            _ => act(&self.subject, &Action::ReleaseAll),
        }
    }
}

fn act(subject: &Running, action: &Action) -> Value {
    match subject.act(OPERATOR, action) {
        Ok(()) => json!({ "success": true, "message": "" }),
        Err(refusal) => json!({ "success": false, "message": refusal.error }),
    }
}

/// The response to `get_type_description`, without the text of the definitions.
fn describe_type(request: &Value) -> Value {
    let [name, hash] = ["type_name", "type_hash"].map(|field| request[field].as_str().unwrap_or_default());
    let has_hash = standard().hash(name).is_some_and(|known| known == hash);
    match standard().description(name).filter(|_| has_hash) {
        Some(description) => json!({ "successful": true, "type_description": description }),
        None => {
            json!({ "failure_reason": format!("{name} with the hash {hash} is not a type of this node") })
        }
    }
}
