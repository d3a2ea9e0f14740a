//! Listens for browsers, and gives each its connection. Two threads serve all pages; what waits for the application waits
//! on threads of its own.

use std::collections::HashMap;
use std::future::Future;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use jde_link::Remote;
use jde_link::message::Action;
use parking_lot::Mutex;
use serde::{Deserialize, Serialize};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::runtime::Builder;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot, watch};
use tokio::time::{MissedTickBehavior, interval, sleep, timeout};
use tokio_rustls::TlsAcceptor;

use crate::feeds::{self, Feeds};
use crate::foxglove::{self, Guest, Hub};
use crate::http::{Gate, Opened};
use crate::model::Model;
use crate::newcomers::{Newcomers, Place};
use crate::origin::Places;
use crate::settings::{Right, Settings};
use crate::state::{self, DrivingView};
use crate::token::Tokens;
use crate::{Error, http, socket, tls};

/// How often the pages get the state.
const INTERVAL: Duration = Duration::from_millis(200);
/// Pages at once: a class, twice.
pub(crate) const MAX_PAGES: usize = 64;
/// Pages that only look among them: the others are kept for those who may stop the robot.
const MAX_ONLOOKERS: usize = 48;
/// Connections that have not shown a token. Each step up to it has 5 s.
const MAX_NEWCOMERS: usize = 64;
/// Bytes under way to a page that are not acknowledged: enough for 300 kB a second over 200 ms.
const MAX_UNSENT: u32 = 64 << 10;
/// Connections that wait to be accepted.
const MAX_WAITING: u32 = 256;
/// How long a greeting of TLS may take.
const GREETING: Duration = Duration::from_secs(5);
/// The threads that wait for the application: each page has a few orders at once.
const MAX_WAITING_THREADS: usize = 400;
/// How long the last state may take to the pages.
const FAREWELL: Duration = Duration::from_secs(1);

/// Where people find the page.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Addresses {
    /// With the right to operate, if anybody may have it.
    pub operate: Option<String>,
    /// With the right to look.
    pub read: String,
    /// For Foxglove and Lichtblick, with the right of the first that there is.
    pub foxglove: String,
}

/// A seat among the pages, until it is dropped.
pub(crate) struct Admission {
    _seat: OwnedSemaphorePermit,
    _onlooker: Option<OwnedSemaphorePermit>,
}

/// Who has entered.
enum Entered<S> {
    Page(socket::Entered<S>),
    Guest(S, Guest),
}

/// What all connections share.
pub(crate) struct Page {
    pub(crate) model: Model,
    pub(crate) tokens: Tokens,
    pub(crate) places: Places,
    pub(crate) addresses: Addresses,
    /// Whether the application lets this process only read, so that no page can operate.
    pub(crate) is_link_read_only: bool,
    /// The newest state. It ends with the page.
    pub(crate) state: watch::Receiver<String>,
    /// Those who drive by hand, by teleoperator, each with the number of the socket.
    pub(crate) drivers: Mutex<HashMap<String, (u64, DrivingView)>>,
    pub(crate) feeds: Feeds,
    pub(crate) foxglove: Hub,
    seats: Arc<Semaphore>,
    onlookers: Arc<Semaphore>,
    newcomers: Arc<Newcomers>,
    sockets: AtomicU64,
    started: Instant,
}

impl Page {
    /// Returns the time since the start in ms, by which pages say how old their picture is.
    pub(crate) fn tick(&self) -> u64 {
        u64::try_from(self.started.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    /// Returns a number that no other socket has.
    pub(crate) fn next_socket(&self) -> u64 {
        self.sockets.fetch_add(1, Ordering::Relaxed)
    }

    /// Returns a seat for somebody with this right, if there is one.
    pub(crate) fn admit(&self, right: Right) -> Option<Admission> {
        let onlooker = match right {
            Right::Operate => None,
            Right::Read => Some(Arc::clone(&self.onlookers).try_acquire_owned().ok()?),
        };
        Some(Admission {
            _seat: Arc::clone(&self.seats).try_acquire_owned().ok()?,
            _onlooker: onlooker,
        })
    }

    /// Sends an order to the application without keeping others waiting.
    pub(crate) async fn operate(
        self: &Arc<Self>,
        by: &str,
        action: Action,
        lease_ms: Option<u64>,
    ) -> Result<String, String> {
        let (page, by) = (Arc::clone(self), by.to_owned());
        let answer = tokio::task::spawn_blocking(move || page.model.operate(&by, action, lease_ms)).await;
        answer.unwrap_or_else(|error| Err(error.to_string()))
    }
}

/// Serves the page of an application until the application is gone or `ended` is done. Calls `opened` once with the addresses.
///
/// # Errors
/// The application gives no answer, the address cannot be used, or the certificate cannot.
pub fn serve(
    settings: &Settings,
    remote: Remote,
    opened: impl FnOnce(&Addresses),
    ended: impl Future<Output = ()>,
) -> Result<(), Error> {
    let acceptor = settings.tls.as_ref().map(tls::acceptor).transpose()?;
    let (gone, was_gone) = oneshot::channel();
    remote.on_gone(move || _ = gone.send(()));
    let is_link_read_only = !remote.may_operate();
    let access = if is_link_read_only {
        Right::Read
    } else {
        settings.access
    };
    let model = Model::open(remote)?;
    let tokens = Tokens::new(access)?;
    // The link's library refuses to be called below a runtime of one thread.
    let runtime = Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .max_blocking_threads(MAX_WAITING_THREADS)
        .build()?;
    let served = runtime.block_on(async {
        let listener = listen(settings)?;
        let address = listener.local_addr()?;
        let places = Places::new(acceptor.is_some(), address.port(), &settings.hosts);
        let places = places.with_origins(&settings.origins);
        let base = places.origin(&shown_host(settings, address));
        let link = |right| tokens.of(right).map(|token| format!("{base}/#{token}"));
        let (operate, read) = (link(Right::Operate), link(Right::Read).unwrap_or_default());
        let best = operate.as_ref().unwrap_or(&read).replacen("http", "ws", 1);
        let addresses = Addresses {
            foxglove: best.replacen("/#", &format!("{}?token=", foxglove::PATH), 1),
            operate,
            read,
        };
        opened(&addresses);
        let (newest, state) = watch::channel(state::message(&model, Vec::new(), false));
        let page = Arc::new(Page {
            foxglove: Hub::new(&model)?,
            model,
            tokens,
            places,
            addresses,
            is_link_read_only,
            state,
            drivers: Mutex::default(),
            feeds: Feeds::default(),
            seats: Arc::new(Semaphore::new(MAX_PAGES)),
            onlookers: Arc::new(Semaphore::new(MAX_ONLOOKERS)),
            newcomers: Newcomers::new(MAX_NEWCOMERS),
            sockets: AtomicU64::new(1),
            started: Instant::now(),
        });
        tokio::select! {
            () = accept(&page, &listener, acceptor.as_ref()) => {}
            () = refresh(&page, &newest) => {}
            () = feeds::keep(&page) => {}
            _ = was_gone => {}
            () = ended => {}
        }
        let _ = timeout(FAREWELL, known_end(&page.model)).await;
        let _ = newest.send(state::message(&page.model, Vec::new(), true));
        drop((newest, listener));
        // Each page takes the last state and leaves.
        let all = u32::try_from(MAX_PAGES).unwrap_or(u32::MAX);
        let _ = timeout(FAREWELL, page.seats.acquire_many(all)).await;
        Ok(())
    });
    // An order that still waits for the application keeps the page's process no longer.
    runtime.shutdown_timeout(FAREWELL);
    served
}

/// Waits until the record of the application's end has arrived.
async fn known_end(model: &Model) {
    let mut ticks = interval(INTERVAL);
    while model.present().timeline.ending().is_none() {
        ticks.tick().await;
    }
}

fn listen(settings: &Settings) -> Result<TcpListener, Error> {
    let mut failure = None;
    for address in settings.candidates() {
        match bind(address) {
            Ok(listener) => return Ok(listener),
            Err(reason) => {
                let address = address.to_string();
                failure = failure.or(Some(Error::Listen { address, reason }));
            }
        }
    }
    Err(failure.unwrap_or_else(|| Error::System(io::ErrorKind::AddrNotAvailable.into())))
}

/// Listens with small buffers: what a browser does not read waits in the page, where the newest state replaces it.
fn bind(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = if address.is_ipv4() {
        TcpSocket::new_v4()
    } else {
        TcpSocket::new_v6()
    }?;
    socket.set_reuseaddr(true)?;
    socket.set_send_buffer_size(MAX_UNSENT)?;
    socket.bind(address)?;
    socket.listen(MAX_WAITING)
}

/// The host in the address that people get: the first listed name, or else a number by which others reach this machine.
fn shown_host(settings: &Settings, address: SocketAddr) -> String {
    let port = address.port();
    if let Some(host) = settings.hosts.first() {
        return if host.contains(':') {
            host.clone()
        } else {
            format!("{host}:{port}")
        };
    }
    let number = if address.ip().is_unspecified() {
        outgoing()
    } else {
        address.ip()
    };
    SocketAddr::new(number, port).to_string()
}

/// The number of this machine on the network through which it reaches others. Sends nothing: the address is one that
/// documents use.
fn outgoing() -> IpAddr {
    let ask = || -> io::Result<IpAddr> {
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        socket.connect((Ipv4Addr::new(192, 0, 2, 1), 9))?;
        Ok(socket.local_addr()?.ip())
    };
    ask().unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST))
}

async fn accept(page: &Arc<Page>, listener: &TcpListener, acceptor: Option<&TlsAcceptor>) {
    loop {
        let (stream, from) = match listener.accept().await {
            Ok((stream, from)) => (stream, from.ip()),
            Err(error) => {
                // No descriptor is free, or the browser is gone already.
                tracing::debug!("a browser cannot be served: {error}");
                sleep(INTERVAL).await;
                continue;
            }
        };
        if let Some(place) = page.newcomers.admit(page.next_socket(), from) {
            let (page, acceptor) = (Arc::clone(page), acceptor.cloned());
            tokio::spawn(async move {
                // A browser that is gone, or says nonsense, is nobody's fault.
                if let Err(error) = connection(page, (stream, from), acceptor, place).await {
                    tracing::debug!("a connection of a browser ended: {error}");
                }
            });
        }
    }
}

async fn connection(
    page: Arc<Page>,
    (stream, from): (TcpStream, IpAddr),
    acceptor: Option<TlsAcceptor>,
    mut place: Place,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let arrived = (from, stream.local_addr()?);
    let Some(acceptor) = acceptor else {
        return visit(page, stream, arrived, place).await;
    };
    match place.during(timeout(GREETING, acceptor.accept(stream))).await {
        Some(greeted) => visit(page, greeted??, arrived, place).await,
        None => Ok(()),
    }
}

async fn visit<S>(
    page: Arc<Page>,
    mut stream: S,
    (from, arrived_at): (IpAddr, SocketAddr),
    mut place: Place,
) -> io::Result<()>
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let entering = async {
        let gate = Gate {
            places: &page.places,
            tokens: &page.tokens,
            layout: &page.foxglove.layout,
        };
        io::Result::Ok(match http::answer(&mut stream, &gate, arrived_at).await? {
            None => None,
            Some(Opened::Page) => socket::enter(&page, stream, from).await.map(Entered::Page),
            Some(Opened::Guest(guest)) => Some(Entered::Guest(stream, guest)),
        })
    };
    let entered = place.during(entering).await.unwrap_or(Ok(None))?;
    drop(place);
    match entered {
        None => {}
        Some(Entered::Page(entered)) => socket::serve(page, entered).await,
        Some(Entered::Guest(stream, guest)) => foxglove::serve(page, stream, from, guest).await,
    }
    Ok(())
}

/// Makes the newest state for as long as anybody looks.
async fn refresh(page: &Arc<Page>, newest: &watch::Sender<String>) {
    let mut ticks = interval(INTERVAL);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        ticks.tick().await;
        if page.seats.available_permits() < MAX_PAGES {
            let driving = page
                .drivers
                .lock()
                .values()
                .map(|(_, view)| view.clone())
                .collect();
            newest.send_replace(state::message(&page.model, driving, false));
        }
    }
}
