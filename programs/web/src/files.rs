//! The files of the page, which are part of the program, and the headers with which a browser gets them. Nothing is loaded
//! from elsewhere, and no other site may show the page in a frame.

/// A file of the page.
pub(crate) struct PageFile {
    path: &'static str,
    pub(crate) media_type: &'static str,
    pub(crate) text: &'static str,
}

const FILES: &[PageFile] = &[
    PageFile {
        path: "/",
        media_type: "text/html; charset=utf-8",
        text: include_str!("../page/index.html"),
    },
    PageFile {
        path: "/page.css",
        media_type: "text/css; charset=utf-8",
        text: include_str!("../page/page.css"),
    },
    PageFile {
        path: "/page.js",
        media_type: "text/javascript; charset=utf-8",
        text: include_str!("../page/page.js"),
    },
    PageFile {
        path: "/view.js",
        media_type: "text/javascript; charset=utf-8",
        text: include_str!("../page/view.js"),
    },
    PageFile {
        path: "/pad.js",
        media_type: "text/javascript; charset=utf-8",
        text: include_str!("../page/pad.js"),
    },
    PageFile {
        path: "/draw.js",
        media_type: "text/javascript; charset=utf-8",
        text: include_str!("../page/draw.js"),
    },
    PageFile {
        path: "/panel.js",
        media_type: "text/javascript; charset=utf-8",
        text: include_str!("../page/panel.js"),
    },
    PageFile {
        path: "/curves.js",
        media_type: "text/javascript; charset=utf-8",
        text: include_str!("../page/curves.js"),
    },
    PageFile {
        path: "/icon.svg",
        media_type: "image/svg+xml",
        text: include_str!("../page/icon.svg"),
    },
];

/// Returns the file of a path.
pub(crate) fn find(path: &str) -> Option<&'static PageFile> {
    FILES.iter().find(|file| file.path == path)
}

/// Returns the headers of every answer, for a page of this origin. Scripts come from the page's own files alone, and no text
/// of a robot can become one.
pub(crate) fn headers(origin: &str) -> String {
    // Older browsers do not count a WebSocket as `'self'`.
    let socket = origin.replacen("http", "ws", 1);
    let policy = format!(
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self' {socket}; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'; trusted-types 'none'"
    );
    format!(
        "Content-Security-Policy: {policy}\r\nX-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\n\
         Referrer-Policy: no-referrer\r\nCross-Origin-Opener-Policy: same-origin\r\n\
         Cross-Origin-Resource-Policy: same-origin\r\nCache-Control: no-store\r\nConnection: close\r\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_that_the_page_names_is_part_of_the_program() {
        for file in FILES {
            let is_path =
                |part: &&str| part.starts_with('/') && part.len() > 1 && !part.contains(char::is_whitespace);
            for part in file.text.split(['"', '\'']).filter(is_path) {
                assert!(find(part).is_some(), "{}: {part}", file.path);
            }
        }
        assert!(find("/page.js").is_some() && find("/../Cargo.toml").is_none() && find("").is_none());
    }

    #[test]
    fn the_page_loads_nothing_from_elsewhere_and_has_no_code_in_its_text() {
        for file in FILES {
            let is_namespace = |part: &str| part.starts_with("//www.w3.org/");
            let addresses = file
                .text
                .split("http:")
                .skip(1)
                .chain(file.text.split("https:").skip(1));
            for address in addresses {
                assert!(is_namespace(address), "{}: {address:.40}", file.path);
            }
            for forbidden in [
                "innerHTML",
                "outerHTML",
                "insertAdjacentHTML",
                "document.write",
                "eval(",
                "alert(",
                "confirm(",
                "<dialog",
                "showModal",
                "cookie",
                "localStorage.token",
                " onclick=",
                " style=",
                "<style",
            ] {
                assert!(!file.text.contains(forbidden), "{}: {forbidden}", file.path);
            }
        }
    }

    #[test]
    fn the_policy_names_the_socket_of_the_page() {
        assert!(headers("https://robot.local").contains("connect-src 'self' wss://robot.local;"));
        assert!(headers("http://127.0.0.1:7480").contains("connect-src 'self' ws://127.0.0.1:7480;"));
    }
}
