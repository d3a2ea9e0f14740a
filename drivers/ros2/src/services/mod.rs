//! Services by the application file: the requests and responses of both sides are variables.

mod client;
mod server;
mod settings;

use std::sync::Arc;

use jde_ros_node::{Service, Settings, names};
use jde_schema::describe::Type;
use jde_schema::prelude::*;
use jde_schema::{ListedExport, ListedImport};

use crate::clock_source::FollowedClock;
use crate::connection::{RosConnection, arrival};
use crate::goal;
use crate::settings::node_schema;
use client::ServiceClient;
use server::ServiceServer;
pub(crate) use settings::{Plain, Timed};

node_schema! {
    /// Calls services of other nodes, and offers services whose requests schemas answer. The keys of the lists are names
    /// of services, relative to the namespace unless they begin with `/`.
    ///
    /// A service has a request in one list, and its response in another one under the same key. Their types are named
    /// `PACKAGE/srv/NAME_Request` and `PACKAGE/srv/NAME_Response`. Each service has one request under way at a time.
    #[schema(driver, period = "20ms", budget = "20ms")]
    pub struct Services {
        /// The clock of the stamps in requests and responses: `wall`, or `follow` for that of `/clock`.
        #[modulation(default = FollowedClock::Wall)]
        clock: Modulation<FollowedClock>,
        /// The requests to other nodes: each new value is one.
        #[imports(default = Timed::DEFAULT)]
        send_request: Imports<Timed>,
        /// Their responses, each with the time of its request.
        #[exports(default = Plain::DEFAULT, lasting)]
        take_response: Exports<Plain>,
        /// The requests of other nodes, each until its response.
        #[exports(default = Timed::DEFAULT, lasting)]
        take_request: Exports<Timed>,
        /// Their responses: the next new value.
        #[imports(default = Plain::DEFAULT)]
        send_response: Imports<Plain>,
        /// Whether the router or other nodes are connected.
        #[export(lasting)]
        connection: Export<Connection>,
        active: Option<ActiveServices>,
        /// The number of the newest value of each entry of `send_request` that was a request.
        requested: Vec<u64>,
    }
}

/// The node with its services, in the order of the lists that have the timeouts.
struct ActiveServices {
    connection: RosConnection,
    /// Each with the place of its response in `take_response`.
    clients: Vec<(ServiceClient, usize)>,
    /// Each with the place of its response in `send_response`.
    servers: Vec<(ServiceServer, usize)>,
}

impl Schema for Services {
    fn awake(&mut self, cx: &Context) -> Result {
        cx.require_real_time()?;
        if self.active.is_none() {
            self.requested.resize(self.send_request.len(), 0);
            for (import, requested) in self.send_request.iter().zip(&mut self.requested) {
                let old = import
                    .get(cx)
                    .filter(|value| value.age(cx) >= import.settings().timeout());
                *requested = old.map_or(*requested, |value| value.sequence());
            }
            self.active = Some(self.with_settings(cx, |settings| self.start(cx, &settings))?);
        }
        Ok(())
    }

    fn iterate(&mut self, cx: &Context) -> Result {
        let Some(active) = &mut self.active else {
            return Err("it is not awake".into());
        };
        let connection = &mut active.connection;
        connection.begin(cx, self.clock.get(cx).into());
        if connection.clock.is_known() {
            let requests = self.send_request.iter().zip(&mut self.requested);
            for ((client, place), (request, requested)) in active.clients.iter_mut().zip(requests) {
                let response = &mut self.take_response[*place];
                client.exchange(cx, connection, (request, requested), response);
            }
            let requests = self.take_request.iter_mut();
            for ((server, place), request) in active.servers.iter_mut().zip(requests) {
                server.exchange(cx, connection, request, &self.send_response[*place]);
            }
        } else {
            for (server, _) in &mut active.servers {
                server.give_up(connection, "there is no time on /clock yet");
            }
        }
        connection.export_connection(cx, &mut self.connection, None);
        Ok(())
    }

    fn sleep(&mut self, cx: &Context) {
        if let Some(mut active) = self.active.take() {
            for (server, _) in &mut active.servers {
                server.give_up(&active.connection, "the schema that offers it sleeps");
            }
            active.connection.close(cx, &mut self.connection);
            self.take_response
                .iter_mut()
                .for_each(|export| export.retract(cx));
            self.take_request.iter_mut().for_each(|export| export.retract(cx));
        }
    }
}

impl Inspect for Services {
    fn inspect(&self, cx: &Context, problems: &mut Problems) {
        let namespace = self.inspect_node(cx, &[], problems);
        problems.expect(
            &self.connect,
            self.with_settings(cx, |settings| goal::refuse_bridge(&settings)),
        );
        for import in self.send_request.iter() {
            problems.expect(import, self.client(&namespace, import));
        }
        for export in self.take_request.iter() {
            problems.expect(export, self.server(&namespace, export));
        }
        for export in self.take_response.iter() {
            let requests = self.send_request.iter().map(ListedImport::label);
            problems.expect(
                export,
                partner(requests, export.label(), "send_request", SERVICE_PARTS),
            );
        }
        for import in self.send_response.iter() {
            let requests = self.take_request.iter().map(ListedExport::label);
            problems.expect(
                import,
                partner(requests, import.label(), "take_request", SERVICE_PARTS),
            );
        }
    }
}

impl Services {
    fn start(&self, cx: &Context, settings: &Settings<'_>) -> Result<ActiveServices> {
        goal::refuse_bridge(settings)?;
        let mut config = settings.node_config()?;
        config.arrival = arrival(cx);
        let namespace = config.name.namespace.clone();
        let (mut clients, mut servers) = (Vec::new(), Vec::new());
        for import in self.send_request.iter() {
            let entry = |error| format!("`{}` in `send_request`: {error}", import.label());
            let (service, place) = self.client(&namespace, import).map_err(entry)?;
            let response = &self.take_response[place];
            clients.push((ServiceClient::new(service, import, response, &mut config), place));
        }
        for export in self.take_request.iter() {
            let entry = |error| format!("`{}` in `take_request`: {error}", export.label());
            let (service, place) = self.server(&namespace, export).map_err(entry)?;
            let response = &self.send_response[place];
            servers.push((ServiceServer::new(service, export, response, &mut config), place));
        }
        Ok(ActiveServices {
            connection: RosConnection::start(config, self.clock.get(cx).into())?,
            clients,
            servers,
        })
    }

    /// Returns the service of an entry of `send_request`, and the place of its response.
    fn client(&self, namespace: &str, request: &ListedImport<Timed>) -> Result<(Service, usize), String> {
        let responses = self.take_response.iter().map(ListedExport::label);
        let place = partner(responses, request.label(), "take_response", SERVICE_PARTS)?;
        let types = (request.value_type(), self.take_response[place].value_type());
        Ok((
            service(namespace, request.label(), request.settings(), types)?,
            place,
        ))
    }

    /// Returns the service of an entry of `take_request`, and the place of its response.
    fn server(&self, namespace: &str, request: &ListedExport<Timed>) -> Result<(Service, usize), String> {
        let responses = self.send_response.iter().map(ListedImport::label);
        let place = partner(responses, request.label(), "send_response", SERVICE_PARTS)?;
        let name = |entry: &ListedExport<Timed>| names::topic(namespace, entry.label()).ok().flatten();
        let mut earlier = self.take_request.iter().map_while(|entry| {
            let is_earlier = entry.label() != request.label();
            is_earlier.then(|| (entry.label(), name(entry)))
        });
        if let Some((twin, _)) = earlier.find(|(_, other)| *other == name(request)) {
            return Err(format!("`{twin}` is the same service"));
        }
        let types = (request.value_type(), self.send_response[place].value_type());
        Ok((
            service(namespace, request.label(), request.settings(), types)?,
            place,
        ))
    }
}

/// Returns the place of that key among those of a list.
///
/// # Errors
/// If there is none. `whole` says what consists of entries in several lists.
pub(crate) fn partner(
    mut keys: impl Iterator<Item = &'static str>,
    key: &str,
    list: &str,
    whole: &str,
) -> Result<usize, String> {
    let place = keys.position(|other| other == key);
    place.ok_or_else(|| format!("`{list}` has no entry of this name; {whole}"))
}

/// What a service consists of.
const SERVICE_PARTS: &str = "a service has a request and a response";

/// Returns the service of that key.
fn service(
    namespace: &str,
    key: &str,
    settings: &Timed,
    (request, response): (&Arc<Type>, &Arc<Type>),
) -> Result<Service, String> {
    settings.check()?;
    let name = names::topic(namespace, key)?.ok_or("a service has a name")?;
    Service::of_values(name, request, response)
}
