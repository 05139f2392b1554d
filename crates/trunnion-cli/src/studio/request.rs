//! The part of HTTP/1.1 that a browser needs to load a page.

use std::io::{BufRead, Write};

/// Longest head of a request \[bytes\].
const LONGEST: u64 = 16 << 10;

/// Request for a file.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct PageRequest {
    /// Path without `/` in front and without a query.
    pub(super) path: String,
    /// Host that the browser means.
    pub(super) host: String,
}

impl PageRequest {
    /// Reads the head of a request; `None` for anything but GET.
    pub(super) fn read(from: impl BufRead) -> Option<Self> {
        let mut lines = from.take(LONGEST).lines();
        let first = lines.next()?.ok()?;
        let mut words = first.split_ascii_whitespace();
        let (method, target) = (words.next()?, words.next()?);
        let path = target.split(['?', '#']).next()?.strip_prefix('/')?.to_owned();
        let mut host = String::new();
        for line in lines {
            let line = line.ok()?;
            if line.is_empty() {
                break;
            }
            let (name, value) = line.split_once(':')?;
            if name.eq_ignore_ascii_case("host") {
                value.trim().clone_into(&mut host);
            }
        }
        (method == "GET").then_some(Self { path, host })
    }
}

/// Answer to a request.
#[derive(Debug)]
pub(super) struct PageReply<'a> {
    pub(super) status: &'static str,
    /// Media type.
    pub(super) kind: &'static str,
    pub(super) body: &'a [u8],
}

impl PageReply<'_> {
    pub(super) fn write(&self, mut to: impl Write) -> std::io::Result<()> {
        let Self { status, kind, body } = self;
        write!(
            to,
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
             X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
            body.len()
        )?;
        to.write_all(body)?;
        to.flush()
    }
}

/// Returns the media type of a file name.
pub(super) fn media_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map_or("", |(_, ending)| ending) {
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" => "application/json",
        // Browsers compile it while it arrives only under this type.
        "wasm" => "application/wasm",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_of_a_request_is_read() {
        let read = |text: &str| PageRequest::read(text.as_bytes());
        let request = read("GET /samples/a.toml?x=1 HTTP/1.1\r\nHost: 127.0.0.1:80\r\n\r\n");
        let expected = PageRequest { path: "samples/a.toml".into(), host: "127.0.0.1:80".into() };
        assert_eq!(request, Some(expected));
        for wrong in ["", "GET", "POST / HTTP/1.1\r\n\r\n", "GET http://a/ HTTP/1.1\r\n\r\n"] {
            assert_eq!(read(wrong), None, "{wrong:?}");
        }
    }
}
