use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use backseat_core::Grant;
use backseat_core::plugin::{Description, Topic};
use backseat_plugin_host::{Budget, COMPONENT_BYTES, Host, HostError, check_form};
use backseat_plugin_loader::regular_file;
use serde::{Serialize, Serializer};
use wasmparser::{ComponentExternalKind, ComponentTypeRef, Parser, Payload, TypeBounds};

use crate::error::{ToolError, of_file};
use crate::project::Project;
use crate::sha256;

/// The package of our interfaces.
const PACKAGE: &str = "backseat:plugin";

/// A component's file, read and not yet compiled.
#[derive(Clone, Debug)]
pub struct ComponentFile {
    /// Its path.
    pub path: PathBuf,
    /// Its content.
    pub bytes: Vec<u8>,
    /// SHA-256 of its content, hexadecimal.
    pub sha256: String,
    /// What it imports and exports.
    pub interface: Interface,
}

/// What a component imports and exports, as its file says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Interface {
    /// The interfaces and functions that it imports, with their versions.
    pub imports: Vec<String>,
    /// The names of its exports.
    pub exports: Vec<String>,
}

impl ComponentFile {
    /// Reads a component: a file, or that of a plugin's folder. A file that is too large is not read.
    ///
    /// # Errors
    ///
    /// [`ToolError::Component`] with what the file is if it is no component, [`ToolError::NotBuilt`] if a folder has
    /// none, [`ToolError::File`] if it cannot be read.
    pub fn read(path: &Path) -> Result<Self, ToolError> {
        if path.is_dir() {
            return Self::read(&Project::open(path)?.built()?);
        }
        let name = path.display().to_string();
        let size = regular_file(path).map_err(of_file(path))?;
        let file = File::open(path).map_err(of_file(path))?;
        let size = usize::try_from(size).unwrap_or(usize::MAX);
        if size > COMPONENT_BYTES {
            return Err(ToolError::Component(HostError::TooLarge {
                plugin: name,
                bytes: size,
                bytes_max: COMPONENT_BYTES,
            }));
        }
        let mut bytes = Vec::with_capacity(size);
        // It may grow.
        let mut bounded = file.take(COMPONENT_BYTES as u64 + 1);
        bounded.read_to_end(&mut bytes).map_err(of_file(path))?;
        check_form(&name, &bytes, COMPONENT_BYTES)?;
        let interface = Interface::of(&bytes).map_err(|reason| HostError::Invalid { plugin: name, reason })?;
        Ok(Self {
            path: path.to_path_buf(),
            sha256: sha256(&bytes),
            interface,
            bytes,
        })
    }

    /// What it says about itself, if it is a plugin. Compiles it, or takes it from the host's cache.
    #[must_use]
    pub fn inspect(&self, host: &Host) -> Inspection<'_> {
        let name = self.path.display().to_string();
        let described = host
            .load(&name, &self.bytes)
            .and_then(|component| component.describe(&Budget::default()));
        let (description, needs, refusal) = match described {
            Ok((description, needs)) => (Some(description), needs, None),
            Err(error) => (None, Vec::new(), Some(error.to_string())),
        };
        Inspection {
            file: &self.path,
            sha256: &self.sha256,
            bytes: self.bytes.len(),
            interface: self.interface.versions(),
            wasi: self.interface.wasi(),
            imports: &self.interface.imports,
            exports: &self.interface.exports,
            description,
            needs,
            refusal,
        }
    }
}

/// What is known of a component without a mission.
#[derive(Clone, Debug, Serialize)]
pub struct Inspection<'a> {
    /// The file.
    pub file: &'a Path,
    /// SHA-256 of its content, hexadecimal.
    pub sha256: &'a str,
    /// Its size.
    pub bytes: usize,
    /// The versions of `backseat:plugin` that it was built against.
    pub interface: Vec<String>,
    /// Its imports of WASI: files, network, clocks and random numbers of the system. A plugin has none.
    pub wasi: Vec<&'a str>,
    /// Everything that it imports.
    pub imports: &'a [String],
    /// Everything that it exports.
    pub exports: &'a [String],
    /// What the plugin says about itself.
    #[serde(serialize_with = "description")]
    pub description: Option<Description>,
    /// The grants without which it cannot work, by its own word.
    pub needs: Vec<Grant>,
    /// Why it is no plugin that this program can run, in one line.
    pub refusal: Option<String>,
}

impl Inspection<'_> {
    /// The names of the grants that it needs.
    #[must_use]
    pub fn needed(&self) -> Vec<&'static str> {
        self.needs.iter().map(|grant| grant.name()).collect()
    }

    /// What the plugin listens to, by the names in the interface.
    #[must_use]
    pub fn topics(&self) -> Vec<&'static str> {
        let topics = self.description.iter().flat_map(|described| &described.topics);
        topics.map(|topic| topic_name(*topic)).collect()
    }
}

impl Interface {
    /// Reads the imports and exports of a component.
    ///
    /// # Errors
    ///
    /// What is damaged, and where.
    fn of(bytes: &[u8]) -> Result<Self, String> {
        let mut interface = Self::default();
        let one_line = |error: wasmparser::BinaryReaderError| error.to_string().replace('\n', " ");
        // How many components and modules the parser is in, below the outermost one.
        let mut depth = 0_usize;
        for payload in Parser::new(0).parse_all(bytes) {
            let payload = payload.map_err(one_line)?;
            if let Payload::ModuleSection { .. } | Payload::ComponentSection { .. } = payload {
                depth += 1;
            } else if let Payload::End(_) = payload {
                depth = depth.saturating_sub(1);
            } else if depth > 0 {
                continue;
            } else if let Payload::ComponentImportSection(imports) = payload {
                for import in imports {
                    let import = import.map_err(one_line)?;
                    // A type that equals another one asks for nothing.
                    if !matches!(import.ty, ComponentTypeRef::Type(TypeBounds::Eq(_))) {
                        interface.imports.push(import.name.name.to_owned());
                    }
                }
            } else if let Payload::ComponentExportSection(exports) = payload {
                for export in exports {
                    let export = export.map_err(one_line)?;
                    if export.kind != ComponentExternalKind::Type {
                        interface.exports.push(export.name.name.to_owned());
                    }
                }
            }
        }
        Ok(interface)
    }

    /// The versions of our interface that it names: `backseat:plugin@0.1.0`. One, for a plugin.
    #[must_use]
    pub fn versions(&self) -> Vec<String> {
        let versions: BTreeSet<String> = self
            .imports
            .iter()
            .chain(&self.exports)
            .filter_map(|name| {
                let version = name.strip_prefix(PACKAGE)?.strip_prefix('/')?.split_once('@')?.1;
                Some(format!("{PACKAGE}@{version}"))
            })
            .collect();
        versions.into_iter().collect()
    }

    /// Its imports of WASI.
    #[must_use]
    pub fn wasi(&self) -> Vec<&str> {
        let imports = self.imports.iter().map(String::as_str);
        imports.filter(|name| name.starts_with("wasi")).collect()
    }
}

/// A description for programs, with the period's unit in its key.
pub(crate) fn description<S: Serializer>(described: &Option<Description>, to: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Described<'a> {
        name: &'a str,
        version: &'a str,
        step_period_ms: f64,
        topics: Vec<&'static str>,
    }
    let described = described.as_ref().map(|described| Described {
        name: &described.name,
        version: &described.version,
        step_period_ms: described.step_period.as_secs_f64() * 1000.0,
        topics: described.topics.iter().map(|topic| topic_name(*topic)).collect(),
    });
    described.serialize(to)
}

/// The topic's name in the interface.
pub(crate) const fn topic_name(topic: Topic) -> &'static str {
    match topic {
        Topic::Ctd => "ctd",
        Topic::MissionCommand => "mission-command",
        Topic::Behavior => "behavior",
        Topic::Logging => "logging",
        Topic::Topside => "topside",
        Topic::Acoustic => "acoustic",
        Topic::Plan => "plan",
        Topic::Telemetry => "telemetry",
        Topic::SoundVelocity => "sound-velocity",
        Topic::Compass => "compass",
        Topic::Pressure => "pressure",
        Topic::VehicleSpeed => "vehicle-speed",
        Topic::Battery => "battery",
        Topic::Surfaces => "surfaces",
        Topic::Dvl => "dvl",
        Topic::DvlBeams => "dvl-beams",
        Topic::Imu => "imu",
        Topic::Servo => "servo",
        Topic::Trim => "trim",
        Topic::Buoyancy => "buoyancy",
        Topic::RelativeNavigation => "relative-navigation",
        Topic::Sidescan => "sidescan",
        Topic::SubBottom => "sub-bottom",
        Topic::Sonar => "sonar",
    }
}
