//! A service of this node: each request is exported, and the next new value of a variable is its response.

use jde_ros_node::{NodeConfig, Request, Service};
use jde_schema::describe::{Form, Type};
use jde_schema::prelude::*;
use jde_schema::{ListedExport, ListedImport};

use super::settings::{Plain, Timed};
use crate::connection::RosConnection;
use crate::described::DescribedCodec;

/// A service, and the request that it serves.
pub(super) struct ServiceServer {
    /// Its number among the services of the node.
    number: usize,
    name: String,
    request: DescribedCodec,
    response: DescribedCodec,
    timeout: Duration,
    serving: Option<Serving>,
}

/// A request that is exported.
struct Serving {
    request: Request,
    /// The time just before its export.
    since: Duration,
    /// The number of the newest value that was there before.
    before: u64,
}

impl ServiceServer {
    /// Adds the service to those of the node.
    pub(super) fn new(
        service: Service,
        request: &ListedExport<Timed>,
        response: &ListedImport<Plain>,
        config: &mut NodeConfig,
    ) -> Self {
        let (number, name) = (config.services.len(), service.name.clone());
        config.services.push(service);
        Self {
            number,
            name,
            request: DescribedCodec::new(request.value_type()),
            response: DescribedCodec::new(response.value_type()),
            timeout: request.settings().timeout(),
            serving: None,
        }
    }

    /// Sends a new value as the response to the request that is exported, or exports the next one.
    pub(super) fn exchange(
        &mut self,
        cx: &Context,
        connection: &mut RosConnection,
        export: &mut ListedExport<Timed>,
        response: &ListedImport<Plain>,
    ) {
        let newest = response.get(cx);
        let number = newest.as_ref().map_or(0, |value| value.sequence());
        if let Some(serving) = &self.serving {
            let is_response = |value: &Sample<'_, [u8]>| {
                value.sequence() != serving.before && value.time() >= serving.since
            };
            if let Some(value) = newest.filter(is_response) {
                let message = self.response.encode(&value, "", value.time(), &connection.clock);
                if let Some(Serving { request, .. }) = self.serving.take() {
                    connection.node.reply(request, message);
                }
            } else if cx.now() >= serving.since + self.timeout {
                let reason = format!("no schema responded within {:?}", self.timeout);
                connection.warn_once(cx, format!("{}: {reason}", self.name));
                if let Some(Serving { request, .. }) = self.serving.take() {
                    self.fail(connection, request, &reason);
                }
            }
            if self.serving.is_none() {
                // Readers see that there is none before there is the next one.
                export.retract(cx);
            }
            return;
        }
        while let Some(request) = connection.node.take_request_of(self.number) {
            if request.received_at.elapsed() >= self.timeout {
                let reason = format!("the requests before it took {:?}", self.timeout);
                self.fail(connection, request, &reason);
                continue;
            }
            // Before the export: a response may have the time of its request.
            let since = cx.now();
            let message = request.message();
            match connection.export(cx, (&self.name, &self.request, &message), Some(since), export) {
                Ok(()) => {
                    self.serving = Some(Serving {
                        request,
                        since,
                        before: number,
                    });
                    return;
                }
                Err(error) => {
                    connection.warn_once(cx, format!("{}: {error}", self.name));
                    connection.node.refuse(request, error);
                }
            }
        }
    }

    /// Ends the request that is exported and those that wait, without a response of a schema.
    pub(super) fn give_up(&mut self, connection: &RosConnection, reason: &str) {
        let exported = self.serving.take().map(|serving| serving.request);
        let waiting = std::iter::from_fn(|| connection.node.take_request_of(self.number));
        for request in exported.into_iter().chain(waiting) {
            self.fail(connection, request, reason);
        }
    }

    /// Answers a request without a schema. A response that has the fields `success` and `message` says why.
    fn fail(&self, connection: &RosConnection, request: Request, reason: &str) {
        match failure(self.response.value_type(), reason) {
            Some(value) => {
                let message = self
                    .response
                    .encode(&value, "", Duration::ZERO, &connection.clock);
                connection.node.reply(request, message);
            }
            None => connection.node.refuse(request, reason.to_owned()),
        }
    }
}

/// Returns the response without success that has this message; `None` if the type has no such fields.
fn failure(value_type: &Type, reason: &str) -> Option<Vec<u8>> {
    let field = |name: &str| value_type.fields.iter().find(|field| field.name == name);
    let message = field("message").filter(|_| field("success").is_some())?;
    let Form::Text {
        capacity,
        length_offset,
    } = message.form
    else {
        return None;
    };
    let text = &reason[..reason.floor_char_boundary(capacity)];
    let mut value = vec![0; value_type.bytes];
    value[message.offset..][..text.len()].copy_from_slice(text.as_bytes());
    value[length_offset..][..4].copy_from_slice(&(text.len() as u32).to_ne_bytes());
    Some(value)
}
