//! `trunnion studio`: the page that plans and checks, from a server on this machine.

mod opened;
mod request;
mod run;
mod server;
mod site;

pub(crate) use run::{StudioArgs, run};
