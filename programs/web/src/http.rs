//! One request of a browser or a client: a file of the page, or the opening of a WebSocket. Every other request is refused.
//! It knows nothing of the robot.

use std::io;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite, AsyncWriteExt as _};
use tokio::time::{sleep, timeout};
use tokio_tungstenite::tungstenite::handshake::derive_accept_key;

use crate::files;
use crate::foxglove::{self, Guest};
use crate::origin::{Places, Refused};
use crate::token::Tokens;

/// The path of the WebSocket.
const SOCKET: &str = "/socket";
/// The longest head of a request, bytes. Browsers send less than 2 kB where nobody sets cookies.
const MAX_HEAD: usize = 8 << 10;
/// Most headers of a request.
const MAX_HEADERS: usize = 64;
/// How long a request may take to arrive, and its answer to be read.
const PATIENCE: Duration = Duration::from_secs(5);

/// How long a wrong token is answered by nothing.
pub(crate) const WRONG_TOKEN: Duration = Duration::from_secs(1);
/// Refusals that are logged: other sites may ask without an end.
const MAX_WARNINGS: u32 = 10;
const UNAUTHORIZED: &str = "401 Unauthorized";

/// What requests are checked by, and the one file that is not the same on every robot.
pub(crate) struct Gate<'p> {
    pub(crate) places: &'p Places,
    pub(crate) tokens: &'p Tokens,
    pub(crate) layout: &'p str,
}

/// What a connection has become.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Opened {
    /// The WebSocket of a page, which has sent nothing yet.
    Page,
    /// The WebSocket of somebody who has shown a token.
    Guest(Guest),
}

/// An answer without a file.
struct Refusal {
    status: &'static str,
    text: String,
}

/// What a request asks for.
#[derive(Debug, PartialEq, Eq)]
enum Asked {
    File(String),
    Socket {
        key: String,
    },
    Foxglove {
        key: String,
        protocol: &'static str,
        guest: Guest,
    },
    Layout,
}

/// A request that may be answered.
#[derive(Debug, PartialEq, Eq)]
struct Request {
    asked: Asked,
    is_head: bool,
    /// The origin of the page.
    origin: String,
}

/// Reads a request and answers it. Returns what the connection is now, if it goes on.
///
/// # Errors
/// The browser is gone, or too slow.
pub(crate) async fn answer<S>(
    stream: &mut S,
    gate: &Gate<'_>,
    arrived_at: SocketAddr,
) -> io::Result<Option<Opened>>
where
    S: AsyncRead + AsyncWrite + Unpin,
{
    let head = timeout(PATIENCE, read_head(stream)).await??;
    let request = read(&head, gate, arrived_at);
    if request
        .as_ref()
        .is_err_and(|refusal| refusal.status == UNAUTHORIZED)
    {
        sleep(WRONG_TOKEN).await;
    }
    let (bytes, opened) = match request {
        Ok(Request {
            asked,
            is_head,
            origin,
        }) => match asked {
            Asked::Socket { key } => (switched(&key, ""), Some(Opened::Page)),
            Asked::Foxglove { key, protocol, guest } => {
                let chosen = format!("Sec-WebSocket-Protocol: {protocol}\r\n");
                (switched(&key, &chosen), Some(Opened::Guest(guest)))
            }
            Asked::File(path) => (file(&path, is_head, &origin), None),
            Asked::Layout => (found("application/json", gate.layout, is_head, &origin), None),
        },
        Err(refusal) => (refused(&refusal), None),
    };
    timeout(PATIENCE, async {
        stream.write_all(bytes.as_bytes()).await?;
        stream.flush().await
    })
    .await??;
    if opened.is_none() {
        // A proper end, so that TLS has its own.
        timeout(PATIENCE, stream.shutdown()).await??;
    }
    Ok(opened)
}

/// Returns the answer that opens a WebSocket.
fn switched(key: &str, more: &str) -> String {
    let accept = derive_accept_key(key.as_bytes());
    format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {accept}\r\n{more}\r\n"
    )
}

/// Reads up to the empty line. Bytes after it would belong to a request that nobody answers.
async fn read_head<S: AsyncRead + Unpin>(stream: &mut S) -> io::Result<Vec<u8>> {
    let mut head = Vec::with_capacity(1024);
    let mut piece = [0; 1024];
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        let length = stream.read(&mut piece).await?;
        if length == 0 || head.len() + length > MAX_HEAD {
            return Err(io::ErrorKind::InvalidData.into());
        }
        head.extend_from_slice(&piece[..length]);
    }
    Ok(head)
}

fn read(head: &[u8], gate: &Gate<'_>, arrived_at: SocketAddr) -> Result<Request, Refusal> {
    let bad = |text: &str| Refusal {
        status: "400 Bad Request",
        text: text.to_owned(),
    };
    let mut headers = [httparse::EMPTY_HEADER; MAX_HEADERS];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(head) {
        // A client that sends frames before it is let in would have them lost.
        Ok(httparse::Status::Complete(length)) if length == head.len() => {}
        Ok(_) | Err(_) => return Err(bad("this is no request of a browser")),
    }
    let header = |name: &str| {
        let mut found = request
            .headers
            .iter()
            .filter(|header| header.name.eq_ignore_ascii_case(name));
        let first = found
            .next()
            .map(|header| std::str::from_utf8(header.value).unwrap_or_default());
        // Of two, one program would check the first and another one the last.
        if found.next().is_some() { Some("") } else { first }
    };
    let places = gate.places;
    let host = places
        .check_host(header("host"), arrived_at)
        .map_err(|refused| refusal(refused, header("host")))?;
    let is_head = request.method == Some("HEAD");
    if !is_head && request.method != Some("GET") {
        return Err(Refusal {
            status: "405 Method Not Allowed",
            text: "this page is only read".to_owned(),
        });
    }
    // The token of a page is behind the `#`, which no browser sends.
    let path = request.path.unwrap_or_default();
    let (path, query) = path.split_once('?').unwrap_or((path, ""));
    let key = || {
        let is_upgrade = header("upgrade").is_some_and(|to| to.eq_ignore_ascii_case("websocket"));
        let key = header("sec-websocket-key").filter(|key| key.len() == 24);
        match (is_upgrade, key, header("sec-websocket-version")) {
            (true, Some(key), Some("13")) => Ok(key.to_owned()),
            _ => Err(bad("this is the address of a WebSocket of version 13")),
        }
    };
    let guest = || {
        foxglove::admit(query, gate.tokens).ok_or_else(|| Refusal {
            status: UNAUTHORIZED,
            text: "The token in this address is not valid: the robot makes a new one at each start. Write \
                   ?token= and the token of the address that the robot printed."
                .to_owned(),
        })
    };
    let origin = header("origin");
    let asked = match path {
        SOCKET => {
            let key = key()?;
            places
                .check_origin(origin, &host)
                .map_err(|refused| refusal(refused, origin))?;
            Asked::Socket { key }
        }
        foxglove::PATH => {
            let key = key()?;
            places
                .check_client(origin, &host)
                .map_err(|refused| refusal(refused, origin))
                .inspect_err(warn)?;
            let protocol = foxglove::protocol(header("sec-websocket-protocol").unwrap_or_default());
            let protocol = protocol.ok_or_else(|| {
                bad("this address speaks the WebSocket protocols foxglove.websocket.v1 and foxglove.sdk.v1: offer one")
            })?;
            let guest = guest()?;
            Asked::Foxglove { key, protocol, guest }
        }
        foxglove::LAYOUT => guest().map(|_| Asked::Layout)?,
        _ => Asked::File(path.to_owned()),
    };
    Ok(Request {
        asked,
        is_head,
        origin: places.origin(&host),
    })
}

/// Logs a refusal whose reason the client shows to nobody, unless there were many.
fn warn(refusal: &Refusal) {
    static WARNINGS: AtomicU32 = AtomicU32::new(0);
    if WARNINGS.fetch_add(1, Ordering::Relaxed) < MAX_WARNINGS {
        tracing::warn!("{}", refusal.text);
    }
}

fn refusal(refused: Refused, shown: Option<&str>) -> Refusal {
    let shown: String = shown
        .unwrap_or("nothing")
        .chars()
        .filter(|letter| letter.is_ascii_graphic())
        .take(100)
        .collect();
    Refusal {
        status: "403 Forbidden",
        text: match refused {
            Refused::Host => format!(
                "The robot's page is not reached under the name {shown}. Use the address that the robot printed, or add the name to hosts in the file of --web."
            ),
            Refused::Origin => {
                format!("Only the robot's own page may open this socket, and the request is from {shown}.")
            }
            Refused::Unlisted => format!(
                "A page of {shown} may not connect. If it is yours, add origins = [\"{shown}\"] to the file of --web."
            ),
        },
    }
}

fn file(path: &str, is_head: bool, origin: &str) -> String {
    let Some(file) = files::find(path) else {
        return refused(&Refusal {
            status: "404 Not Found",
            text: "The robot's page has no such file.".to_owned(),
        });
    };
    found(file.media_type, file.text, is_head, origin)
}

fn found(media_type: &str, text: &str, is_head: bool, origin: &str) -> String {
    let (headers, length) = (files::headers(origin), text.len());
    let body = if is_head { "" } else { text };
    format!(
        "HTTP/1.1 200 OK\r\nContent-Type: {media_type}\r\nContent-Length: {length}\r\n{headers}\r\n{body}"
    )
}

fn refused(Refusal { status, text }: &Refusal) -> String {
    let length = text.len();
    format!(
        "HTTP/1.1 {status}\r\nContent-Type: text/plain; charset=utf-8\r\nContent-Length: {length}\r\n\
         X-Content-Type-Options: nosniff\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n{text}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Right;

    fn ask(request: &str) -> Result<Request, &'static str> {
        ask_with(request, &Tokens::new(Right::Operate).unwrap())
    }

    fn ask_with(request: &str, tokens: &Tokens) -> Result<Request, &'static str> {
        let gate = Gate {
            places: &Places::new(false, 7480, &[]),
            tokens,
            layout: "{}",
        };
        let head = request.replace('\n', "\r\n") + "\r\n\r\n";
        read(head.as_bytes(), &gate, "127.0.0.1:7480".parse().unwrap()).map_err(|refusal| refusal.status)
    }

    const UPGRADE: &str = "GET /socket HTTP/1.1\nHost: localhost:7480\nUpgrade: websocket\nConnection: keep-alive, Upgrade\n\
        Sec-WebSocket-Version: 13\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==";

    #[test]
    fn files_are_read_and_never_written() {
        let request = ask("GET /?a=b HTTP/1.1\nHost: localhost:7480").unwrap();
        assert_eq!(request.asked, Asked::File("/".to_owned()));
        assert_eq!(request.origin, "http://localhost:7480");
        for method in ["POST", "PUT", "DELETE", "OPTIONS", "CONNECT", "get"] {
            let refused = ask(&format!("{method} / HTTP/1.1\nHost: localhost:7480"));
            assert_eq!(refused, Err("405 Method Not Allowed"), "{method}");
        }
        assert!(file("/../Cargo.toml", false, "").starts_with("HTTP/1.1 404"));
        assert!(file("/page.css", true, "").ends_with("\r\n\r\n"));
    }

    #[test]
    fn a_socket_needs_the_origin_of_the_page_itself() {
        let with = |origin: &str| ask(&format!("{UPGRADE}{origin}"));
        assert!(with("\nOrigin: http://localhost:7480").is_ok());
        for origin in [
            "",
            "\nOrigin: null",
            "\nOrigin: http://evil.example",
            "\nOrigin: http://127.0.0.1:7480",
            "\nOrigin: http://localhost:7480\nOrigin: http://evil.example",
        ] {
            assert_eq!(with(origin), Err("403 Forbidden"), "{origin}");
        }
        let old = UPGRADE.replace("Version: 13", "Version: 8") + "\nOrigin: http://localhost:7480";
        assert_eq!(ask(&old), Err("400 Bad Request"));
        assert_eq!(
            ask("GET /socket HTTP/1.1\nHost: localhost:7480"),
            Err("400 Bad Request")
        );
    }

    #[test]
    fn a_client_needs_a_token_and_a_protocol_and_no_foreign_origin() {
        let tokens = Tokens::new(Right::Operate).unwrap();
        let operate = tokens.of(Right::Operate).unwrap();
        let with = |query: &str, more: &str| {
            let request = UPGRADE.replace("/socket", &format!("/foxglove{query}"));
            ask_with(&format!("{request}{more}"), &tokens)
        };
        let token = format!("?token={operate}");
        let protocol = "\nSec-WebSocket-Protocol: foxglove.sdk.v1";
        assert!(with(&token, protocol).is_ok());
        assert!(with(&token, &format!("{protocol}\nOrigin: http://localhost:7480")).is_ok());
        assert_eq!(with(&token, ""), Err("400 Bad Request"));
        assert_eq!(with("", protocol), Err(UNAUTHORIZED));
        for origin in [
            "http://evil.example",
            "null",
            "file://",
            "http://localhost:7480\nOrigin: http://localhost:7480",
        ] {
            assert_eq!(
                with(&token, &format!("{protocol}\nOrigin: {origin}")),
                Err("403 Forbidden"),
                "{origin}"
            );
        }
        let layout = |query: &str| {
            ask_with(
                &format!("GET /foxglove-layout.json{query} HTTP/1.1\nHost: localhost:7480"),
                &tokens,
            )
        };
        assert_eq!(layout(&token).map(|request| request.asked), Ok(Asked::Layout));
        assert_eq!(layout(""), Err(UNAUTHORIZED));
    }

    #[test]
    fn another_name_is_refused_before_anything_else() {
        assert_eq!(
            ask("GET / HTTP/1.1\nHost: rebound.example:7480"),
            Err("403 Forbidden")
        );
        assert_eq!(ask("GET / HTTP/1.1"), Err("403 Forbidden"));
        assert_eq!(
            ask("GET / HTTP/1.1\nHost: localhost:7480\nHost: a"),
            Err("403 Forbidden")
        );
        assert_eq!(ask("nonsense"), Err("400 Bad Request"));
    }
}
