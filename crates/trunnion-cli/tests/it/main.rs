//! Tests of the binary as its users run it: one binary, one module a verb.

mod batch;
mod binary;
mod book;
mod check;
mod cli;
mod conservation;
mod coolant;
mod drawn_program;
mod failures;
mod feed;
mod inspect;
mod linuxcnc;
mod linuxcnc_run;
mod machine;
mod outputs;
mod page;
mod path;
mod post;
mod reference;
mod rs274;
mod setpoints;
mod snapshots;
mod stock;
mod studio;
mod without_part;
