//! Foxglove's WebSocket protocol, so that Foxglove and Lichtblick show a running application: the channels of recordings,
//! parameters and services. Form: `docs/spec.md` of `foxglove/ws-protocol`.
//!
//! The authority of a connection is that of the token in its address. What is broken, unknown or refused is answered by a
//! status message, and ends nothing but itself.
//!
//! **Refuses:** to take messages and to hand out files.

mod channel;
mod entry;
mod feeds;
mod frame;
mod layout;
mod outbox;
mod parameters;
mod request;
mod services;
mod visit;

use std::io;
use std::sync::{Arc, Weak};

use jde_link::message::About;
use serde_json::{Value, json};
use tokio::sync::Mutex;

pub(crate) use entry::{Guest, LAYOUT, PATH, admit, protocol};
pub(crate) use visit::serve;

use crate::model::Model;
use crate::settings::Right;
use channel::Channel;
use feeds::Feeds;
use parameters::Parameters;

/// What all connections of an application share.
pub(crate) struct Hub {
    channels: Arc<Vec<Channel>>,
    feeds: Feeds,
    /// While any connection uses them.
    parameters: Mutex<Weak<Parameters>>,
    /// The layout that shows this application.
    pub(crate) layout: String,
}

impl Hub {
    /// Finds the channels of an application.
    ///
    /// # Errors
    /// The system gives no thread.
    pub(crate) fn new(model: &Model) -> io::Result<Self> {
        let channels = Arc::new(channel::channels(model));
        Ok(Self {
            layout: layout::of(model, &channels).to_string(),
            feeds: Feeds::start(model.remote.clone(), Arc::clone(&channels))?,
            channels,
            parameters: Mutex::default(),
        })
    }

    /// Returns the parameters, which all connections share.
    ///
    /// # Errors
    /// There is no connection to the application, in words.
    async fn parameters(&self, model: &Model) -> Result<Arc<Parameters>, String> {
        let mut shared = self.parameters.lock().await;
        if let Some(parameters) = shared.upgrade() {
            return Ok(parameters);
        }
        let (remote, variables) = (model.remote.clone(), model.variables.clone());
        let opened = tokio::task::spawn_blocking(move || Parameters::open(&remote, &variables)).await;
        let opened = opened.map_err(|error| error.to_string())?;
        let parameters = Arc::new(opened.map_err(|error| error.to_string())?);
        *shared = Arc::downgrade(&parameters);
        Ok(parameters)
    }

    fn advertisement(&self) -> Value {
        let channels = self.channels.iter().enumerate();
        let channels: Vec<Value> = channels
            .map(|(number, channel)| channel.advertisement(number))
            .collect();
        json!({ "op": "advertise", "channels": channels })
    }
}

fn server_info(about: &About, right: Right) -> Value {
    let mut capabilities = vec!["time", "parameters", "parametersSubscribe"];
    if right == Right::Operate {
        capabilities.push("services");
    }
    json!({
        "op": "serverInfo",
        "name": format!("{} on {} (jde {})", about.name, about.host, about.version),
        "capabilities": capabilities,
        "supportedEncodings": [services::ENCODING],
        "metadata": { "application": about.application, "executor": about.executor },
        "sessionId": about.id,
    })
}
