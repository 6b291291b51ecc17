use std::fmt::{self, Display, Formatter};

/// A part of a mission that is not as it was signed. Displays as words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Difference {
    /// The lock is of another mission.
    Mission {
        /// Of which.
        signed: String,
        /// Which one this is.
        loaded: String,
    },
    /// `[limits]`, as `mission.toml` has them.
    Limits,
    /// `[limits]`, by what was set over `mission.toml`.
    LimitsSet,
    /// The fence's file.
    Fence,
    /// The file of the vehicle's plan, or whether there is one.
    Plan,
    /// A plugin's component, or whether there is such a plugin.
    Component(
        /// The plugin's name.
        String,
    ),
    /// `mission.toml`, apart from its limits.
    File,
    /// What was set over `mission.toml`.
    Setting,
    /// The program.
    Program,
}

impl Display for Difference {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mission { signed, loaded } => write!(f, "it is of the mission {signed}, and this is {loaded}"),
            Self::Limits => f.write_str("the limits differ"),
            Self::LimitsSet => f.write_str("the limits differ by a setting of --set or of a BACKSEAT__ variable"),
            Self::Fence => f.write_str("the fence differs"),
            Self::Plan => f.write_str("the plan differs"),
            Self::Component(plugin) => write!(f, "the component of plugin {plugin} differs"),
            Self::File => f.write_str("mission.toml differs"),
            Self::Setting => f.write_str("a setting of --set or of a BACKSEAT__ variable differs"),
            Self::Program => f.write_str("the program differs from the one that signed"),
        }
    }
}
