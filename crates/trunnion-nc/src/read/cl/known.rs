//! Meaning of the major words to a reader of motion.

/// Effect of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WordMeaning {
    Goto,
    Delta,
    Curve,
    From,
    Rapid,
    Feed,
    Circle,
    Arc,
    Direction,
    Units,
    Cutter,
    ToolData,
    Tool,
    Spindle,
    Coolant,
    MultiAxis,
    ToolAxis,
    Frame,
    World,
    Transform,
    Cycle,
    End,
    PathEnd,
    /// Changes nothing here.
    Remark,
    /// No motion, or motion of the machine that the file does not describe.
    Nothing,
    /// Kept, with a warning about what is not followed.
    Doubtful(&'static str),
    /// Moves the tool, or shifts what follows, in a way that is not understood.
    Refused(&'static str),
    Unknown,
}

const OFFSET: &str =
    "the control shifts these moves by its offset table; they are taken as written";
const INSERTED: &str =
    "the text goes into the program as it is; should it move the tool, that is not seen";
const HOME: &str = "the way home is the machine's own; it is not followed";
const CURVE: &str = "post the path as points (linear output)";
const SHIFT: &str = "post the path in one coordinate system";
const SOURCE: &str = "it is of an APT source: process it to a CL file first";
const TABLE: &str = "post the path with the tool axis in every location (i, j, k)";

/// Returns the meaning of a major word in capitals.
pub(super) fn meaning(word: &str) -> WordMeaning {
    use WordMeaning as M;
    match word {
        "GOTO" => M::Goto,
        "GODLTA" => M::Delta,
        "TLON" => M::Curve,
        "FROM" => M::From,
        "RAPID" => M::Rapid,
        "FEDRAT" => M::Feed,
        "CIRCLE" => M::Circle,
        "MOVARC" => M::Arc,
        "INDIRV" | "AUTOPS" => M::Direction,
        "UNITS" | "UNIT" => M::Units,
        "CUTTER" => M::Cutter,
        "TLDATA" => M::ToolData,
        "LOADTL" | "LOAD" | "TURRET" => M::Tool,
        "SPINDL" => M::Spindle,
        "COOLNT" => M::Coolant,
        "MULTAX" => M::MultiAxis,
        "TLAXIS" => M::ToolAxis,
        "MSYS" => M::Frame,
        "CSYS" => M::World,
        "TRNTYP" => M::Transform,
        "CYCLE" => M::Cycle,
        "FINI" => M::End,
        "END-OF-PATH" => M::PathEnd,
        "PAINT" | "DISPLY" | "SEQNO" => M::Remark,
        _ => other(word),
    }
}

/// Returns the meaning of words that do not move the tool, and of those that no reader can follow.
fn other(word: &str) -> WordMeaning {
    use WordMeaning as M;
    match word {
        "PARTNO" | "PPRINT" | "REMARK" | "TITLES" | "LETTER" | "TOOL" | "MACHIN" | "MODE"
        | "HEAD" | "TOLER" | "INTOL" | "OUTTOL" | "SELECT" | "SELCTL" | "OFSTNO" | "TOOLNO"
        | "CLEARP" | "SAFPOS" | "DELAY" | "STOP" | "OPSTOP" | "END" | "CLAMP" | "ORIGIN"
        | "BOX" | "TPRINT" | "NOPOST" | "CLPRNT" | "PRINT" | "TDATA" | "LINTOL" | "ARCDAT" => {
            M::Nothing
        }
        "GO" | "TLLFT" | "TLRGT" | "TLONPS" | "TLOFPS" | "INDIRP" | "PSIS" | "POCKET"
        | "PROFIL" | "SCURV" | "SMILL" | "MACRO" | "CALL" | "LOOPST" | "LOOPND" | "IF" | "DO"
        | "JUMPTO" | "TRANTO" | "REPLAY" | "SYN" => M::Refused(SOURCE),
        "GOFWD" | "GOLFT" | "GORGT" | "GOBACK" | "GOUP" | "GODOWN" | "ARCSLP" | "NURBS"
        | "KNOT" | "CNTRL" | "SPLINE" | "HELIX" | "THREAD" => M::Refused(CURVE),
        "TRANS" | "TRACUT" | "ROTATE" | "COPY" | "INDEX" | "REFSYS" | "MIRROR" => M::Refused(SHIFT),
        "ROTABL" | "ROTHED" | "ORIENT" => M::Refused(TABLE),
        "CUTCOM" => M::Doubtful(OFFSET),
        "INSERT" | "AUXFUN" | "PREFUN" => M::Doubtful(INSERTED),
        "GOHOME" | "RETRCT" => M::Doubtful(HOME),
        _ if word.starts_with("CSI_SET") || word.starts_with("OP_") => M::Nothing,
        _ => M::Unknown,
    }
}
