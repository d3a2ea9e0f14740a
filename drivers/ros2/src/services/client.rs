//! A service of another node: each new value of a variable is a request, and its response is exported.

use jde_ros_node::{Client, NodeConfig, Service};
use jde_schema::prelude::*;
use jde_schema::{ListedExport, ListedImport};

use super::settings::{Plain, Timed};
use crate::connection::RosConnection;
use crate::described::DescribedCodec;

/// A client, and its request.
pub(super) struct ServiceClient {
    /// Its number among the clients of the node.
    number: usize,
    service: Service,
    request: DescribedCodec,
    response: DescribedCodec,
    timeout: Duration,
    pending: Option<Pending>,
    /// Whether the last request had no response.
    fails: bool,
}

/// A request without a response.
struct Pending {
    /// The time of its value.
    time: Duration,
    since: Duration,
    phase: Phase,
}

enum Phase {
    /// No node offers the service yet.
    Waiting(Vec<u8>),
    /// It has this number.
    Sent(i64),
}

impl ServiceClient {
    /// Adds the client to those of the node.
    pub(super) fn new(
        service: Service,
        request: &ListedImport<Timed>,
        response: &ListedExport<Plain>,
        config: &mut NodeConfig,
    ) -> Self {
        let (number, timeout) = (config.clients.len(), request.settings().timeout());
        config.clients.push(Client {
            service: service.clone(),
            timeout,
        });
        Self {
            number,
            service,
            request: DescribedCodec::new(request.value_type()),
            response: DescribedCodec::new(response.value_type()),
            timeout,
            pending: None,
            fails: false,
        }
    }

    /// Exports a response, or sends a new value as a request if there is none under way. `requested` is the number of the
    /// value that was the last request.
    pub(super) fn exchange(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        (request, requested): (&ListedImport<Timed>, &mut u64),
        export: &mut ListedExport<Plain>,
    ) {
        while let Some(response) = connection.node.take_response(self.number) {
            let is_own = |pending: &mut Pending| matches!(pending.phase, Phase::Sent(number) if number == response.sequence);
            if let Some(pending) = self.pending.take_if(is_own) {
                let outcome = response.outcome.and_then(|message| {
                    let response = (&*self.service.name, &self.response, &*message);
                    connection.export(cx, response, Some(pending.time), export)
                });
                self.report(cx, outcome);
                // Its readers shall see it before the next request retracts it.
                return;
            }
        }
        if self.pending.is_none()
            && let Some(value) = request.get(cx)
            && value.sequence() != *requested
        {
            *requested = value.sequence();
            export.retract(cx);
            let message = self.request.encode(&value, "", value.time(), &connection.clock);
            self.pending = Some(Pending {
                time: value.time(),
                since: cx.now(),
                phase: Phase::Waiting(message),
            });
        }
        let Some(pending) = &mut self.pending else { return };
        if cx.now() >= pending.since + self.timeout {
            let waited = match pending.phase {
                Phase::Waiting(_) => "no node offers it",
                Phase::Sent(_) => "there was no response",
            };
            self.pending = None;
            self.report(cx, Err(format!("{waited} within {:?}", self.timeout)));
        } else if let Phase::Waiting(message) = &mut pending.phase
            && connection.node.has_server(self.number)
        {
            let message = core::mem::take(message);
            pending.phase = Phase::Sent(connection.node.call(self.number, message));
            pending.since = cx.now();
        }
    }

    /// Warns of the first request of a row that has no response.
    fn report(&mut self, cx: &Context, outcome: Result<(), String>) {
        match outcome {
            Ok(()) => self.fails = false,
            Err(error) if !core::mem::replace(&mut self.fails, true) => {
                let Service { name, type_name, .. } = &self.service;
                warn!(cx, "a request to {name} ({type_name}) failed: {error}");
            }
            Err(_) => {}
        }
    }
}
