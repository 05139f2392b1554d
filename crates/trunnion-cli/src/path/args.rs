//! Arguments of `trunnion path`.

use crate::option_values::pose_tolerance;
use std::path::PathBuf;
use trunnion::types::PoseTolerance;

#[derive(Debug, clap::Args)]
pub(crate) struct PathArgs {
    /// Job file (TOML), or a CL file (APT/CL as NX, CATIA, Creo, SOLIDWORKS and Autodesk write it); - is stdin.
    pub(super) input: PathBuf,
    /// CL file to write [default: stdout].
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Fit a C3 path within these tolerances of the cutter locations: mm at the tip, degrees of the tool axis.
    /// The written locations stay within them everywhere.
    #[arg(long, value_name = "TIP,AXIS", value_parser = pose_tolerance, allow_hyphen_values = true)]
    pub(super) smooth: Option<PoseTolerance>,
    /// Draw tip and axis deviation along the path (SVG); with --smooth.
    #[arg(long, value_name = "FILE", requires = "smooth")]
    pub(super) chart: Option<PathBuf>,
}
