//! A server that only this machine reaches.

use super::opened::OpenedFiles;
use super::request::{PageReply, PageRequest, media_type};
use super::site::Site;
use crate::outcome::Failure;
use std::io::BufReader;
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::time::Duration;

/// A browser that says nothing for so long is no longer waited for.
const PATIENCE: Duration = Duration::from_secs(10);

/// Server of the page and of the files that it opens.
#[derive(Debug)]
pub(super) struct Server {
    listener: TcpListener,
    address: SocketAddr,
    content: Arc<Content>,
}

#[derive(Debug)]
struct Content {
    site: Site,
    opened: OpenedFiles,
}

impl Server {
    /// Takes a free port of the loopback address.
    pub(super) fn start(site: Site, opened: OpenedFiles) -> Result<Self, Failure> {
        let bound = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).and_then(|listener| {
            let address = listener.local_addr()?;
            Ok((listener, address))
        });
        let (listener, address) = bound
            .map_err(|error| Failure::input(format!("cannot serve on this machine: {error}")))?;
        Ok(Self { listener, address, content: Arc::new(Content { site, opened }) })
    }

    pub(super) fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// Answers browsers until the process ends.
    pub(super) fn serve(&self) {
        let host = self.address.to_string();
        for stream in self.listener.incoming().flatten() {
            let (content, host) = (Arc::clone(&self.content), host.clone());
            // A browser that hangs up needs no answer.
            std::thread::spawn(move || content.answer(&stream, &host));
        }
    }
}

impl Content {
    fn answer(&self, stream: &TcpStream, host: &str) -> std::io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let request = PageRequest::read(BufReader::new(stream));
        // Another host name that leads here is a foreign page that reaches for local files.
        let request = request.filter(|request| request.host == host);
        let found = request.and_then(|PageRequest { path, .. }| {
            let name = if path.is_empty() { "index.html".to_owned() } else { path };
            Some((media_type(&name), self.body(&name)?))
        });
        let reply = match &found {
            Some((kind, body)) => PageReply { status: "200 OK", kind, body },
            None => PageReply { status: "404 Not Found", kind: "text/plain", body: b"not here\n" },
        };
        reply.write(stream)
    }

    fn body(&self, name: &str) -> Option<Vec<u8>> {
        if name == "opened.json" {
            return serde_json::to_vec(&self.opened.names).ok();
        }
        match name.strip_prefix("opened/") {
            Some(at) => self.opened.bytes(at.parse().ok()?),
            None => self.site.file(name).map(std::borrow::Cow::into_owned),
        }
    }
}
