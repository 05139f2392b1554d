//! The verb: finds the site and the files, opens the browser, and serves until it is stopped.

use super::opened::OpenedFiles;
use super::server::Server;
use super::site::Site;
use crate::desktop;
use crate::form::OutputForm;
use crate::outcome::{Done, Failure};
use serde::Serialize;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(crate) struct StudioArgs {
    /// Job, program, CL file, part or machine files to open. The files that a job names are opened with it.
    files: Vec<PathBuf>,
    /// Print the address, and do not open a browser.
    #[arg(long)]
    no_open: bool,
    /// Folder of a built site [default: the site in this program].
    #[arg(long, value_name = "DIR")]
    site: Option<PathBuf>,
}

/// Address of the page.
#[derive(Debug, Serialize)]
struct Address {
    url: String,
}

pub(crate) fn run(args: &StudioArgs, form: OutputForm) -> Result<Done, Failure> {
    let site = Site::find(args.site.as_deref())?;
    let opened = OpenedFiles::of(&args.files)?;
    let server = Server::start(site, opened)?;
    let address = Address { url: server.url() };
    form.print(&address, |address| {
        format!("the studio is at {} until Ctrl-C; only this machine reaches it\n", address.url)
    })?;
    if !args.no_open {
        desktop::open(&address.url)?;
    }
    server.serve();
    Ok(Done::Kept)
}
