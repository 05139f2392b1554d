//! The server of the studio: the page and the files that were named, and nothing else.

#![expect(clippy::unwrap_used, reason = "a test stops on surprise")]

use crate::binary::{folder, trunnion};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A running studio, ended with the test.
struct Studio(Child, String);

impl Drop for Studio {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Studio {
    fn start(folder: &Path, files: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_trunnion"))
            .args(["studio", "--no-open", "--site", "site"])
            .args(files)
            .current_dir(folder)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let (_, rest) = line.split_once("http://").unwrap();
        let (host, _) = rest.split_once('/').unwrap();
        Self(child, host.to_owned())
    }

    /// Returns head and body of an answer.
    fn get(&self, path: &str, host: &str) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.1).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        (String::from_utf8(answer[..end].to_vec()).unwrap(), answer[end + 4..].to_vec())
    }
}

fn with_site() -> tempfile::TempDir {
    let folder = folder();
    fs::create_dir_all(folder.path().join("site/samples")).unwrap();
    fs::write(folder.path().join("site/index.html"), "<!doctype html>").unwrap();
    fs::write(folder.path().join("site/samples/engine.wasm"), b"\0asm").unwrap();
    folder
}

#[test]
fn the_page_and_the_files_of_a_job_are_served() {
    let folder = with_site();
    let studio = Studio::start(folder.path(), &["job.toml"]);
    let host = studio.1.clone();
    assert!(host.starts_with("127.0.0.1:"));
    let (head, body) = studio.get("/", &host);
    assert!(head.starts_with("HTTP/1.1 200") && head.contains("text/html"), "{head}");
    assert_eq!(body, b"<!doctype html>");
    assert!(studio.get("/samples/engine.wasm?v=1", &host).0.contains("application/wasm"));
    let (_, names) = studio.get("/opened.json", &host);
    let names: Vec<String> = serde_json::from_slice(&names).unwrap();
    assert_eq!(names, ["job.toml", "patch.json", "machine.toml"]);
    let (_, part) = studio.get("/opened/1", &host);
    assert_eq!(part, fs::read(folder.path().join("patch.json")).unwrap());
}

#[test]
fn nothing_else_is_served() {
    let folder = with_site();
    fs::write(folder.path().join("secret.txt"), "secret").unwrap();
    let studio = Studio::start(folder.path(), &[]);
    let host = studio.1.clone();
    for path in
        ["/../secret.txt", "/%2e%2e/secret.txt", "//secret.txt", "/opened/0", "/site", "/samples"]
    {
        let (head, body) = studio.get(path, &host);
        assert!(head.starts_with("HTTP/1.1 404"), "{path}: {head}");
        assert!(!body.windows(6).any(|six| six == b"secret"), "{path}");
    }
    // A foreign name that leads to this machine is a page that reaches for local files.
    assert!(studio.get("/", "studio.example:80").0.starts_with("HTTP/1.1 404"));
}

#[test]
fn a_missing_site_or_file_is_refused_in_words() {
    let folder = with_site();
    let refused = |arguments: &[&str]| {
        let output = trunnion(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(refused(&["studio", "--site", "samples"]).contains("no built site"));
    let gone = refused(&["studio", "--no-open", "--site", "site", "gone.toml"]);
    assert!(gone.contains("gone.toml: there is no such file"), "{gone}");
}
