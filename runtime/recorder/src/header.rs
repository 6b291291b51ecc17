use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Duration;

use backseat_core::PluginSetup;
use backseat_units::{Position, Utc};
use mcap::records::Metadata;
use sha2::{Digest, Sha256};

/// Of a component larger than this, only the SHA-256 is recorded, bytes.
pub const COMPONENT_LIMIT: usize = 8 << 20;

/// The version of the format that this crate writes and reads.
pub(crate) const FORMAT: &str = "2";
/// Name of the metadata record about the run.
pub(crate) const RUN: &str = "backseat";
/// Name of the metadata record of what the plugins say about themselves.
pub(crate) const DESCRIPTIONS: &str = "descriptions";
/// Name of the attachment of the plan that the mission names.
pub(crate) const PLAN: &str = "plan.toml";
/// Before the name of a file of the mission that is attached as it was read.
pub(crate) const AS_READ: &str = "as-read/";
/// Name of the metadata record of the components' hashes.
pub(crate) const COMPONENTS: &str = "components";

/// Key of the number of a part, in the metadata record about the run. The first part has none.
pub(crate) const PART: &str = "part";

/// How much is decoded, and how often the log is written to the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// Navigation and truth once a second; written every 60 s of the run's time.
    Simulation,
    /// Everything; written every 3 s.
    Deployed,
}

impl Rate {
    /// The least time between two messages of a decoded channel.
    pub(crate) const fn period(self) -> Duration {
        match self {
            Self::Simulation => Duration::from_secs(1),
            Self::Deployed => Duration::ZERO,
        }
    }

    /// How long a chunk stays open at most, in the run's time.
    pub(crate) const fn flush_period(self) -> Duration {
        match self {
            Self::Simulation => Duration::from_secs(60),
            Self::Deployed => Duration::from_secs(1),
        }
    }

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Simulation => "simulation",
            Self::Deployed => "deployed",
        }
    }

    pub(crate) fn from_name(name: &str) -> Option<Self> {
        [Self::Simulation, Self::Deployed]
            .into_iter()
            .find(|rate| rate.name() == name)
    }
}

/// What a replay needs of the mission, and what the log has in no other form.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sources<'a> {
    /// The plan that the mission names, TOML.
    pub plan: Option<&'a str>,
    /// The name and the text of the fence's file, if [`Header::fence`] was written from another text: a position that is
    /// written and read again is rounded.
    pub fence: Option<(&'a str, &'a str)>,
    /// The plugins with what they say about themselves, in priority order: a component may be too large to be attached.
    pub plugins: &'a [PluginSetup],
}

/// Facts about a run that are known before it begins.
#[derive(Clone, Copy, Debug)]
pub struct Header<'a> {
    /// The UTC at the run's time zero.
    pub utc_at_start: Utc,
    /// How much is decoded.
    pub rate: Rate,
    /// The mission's name.
    pub mission: &'a str,
    /// The simulation's seed; `None` at sea.
    pub seed: Option<u64>,
    /// The mission as resolved from all its layers, TOML.
    pub resolved_mission: &'a str,
    /// The fence, GeoJSON.
    pub fence: &'a str,
    /// The origin of the frame in which core and its plugins count metres: that of the fence.
    pub origin: Position,
    /// The world of a simulation, TOML; `None` at sea.
    pub world: Option<&'a str>,
    /// The plugins' names and components.
    pub components: &'a [(String, Vec<u8>)],
    /// The program's version.
    pub version: &'a str,
    /// For a replay.
    pub sources: Sources<'a>,
}

impl Header<'_> {
    /// The metadata record about the run.
    pub(crate) fn run(&self) -> BTreeMap<String, String> {
        let mut run = BTreeMap::new();
        let mut put = |key: &str, value: String| run.insert(key.to_owned(), value);
        put("format", FORMAT.to_owned());
        put("version", self.version.to_owned());
        put("mission", self.mission.to_owned());
        if let Some(seed) = self.seed {
            put("seed", seed.to_string());
        }
        put("rate", self.rate.name().to_owned());
        put("utc_at_start_ns", self.utc_at_start.as_unix_nanos().to_string());
        put("origin_latitude_deg", self.origin.latitude.as_deg().to_string());
        put("origin_longitude_deg", self.origin.longitude.as_deg().to_string());
        put("mission_sha256", sha256(self.resolved_mission.as_bytes()));
        put("fence_sha256", sha256(self.fence.as_bytes()));
        run
    }

    /// The metadata record of the components' hashes.
    pub(crate) fn component_hashes(&self) -> BTreeMap<String, String> {
        self.components
            .iter()
            .map(|(name, component)| (component_name(name), sha256(component)))
            .collect()
    }

    /// The metadata record of what the plugins say about themselves, JSON.
    pub(crate) fn descriptions(&self) -> BTreeMap<String, String> {
        let plugins = self.sources.plugins.iter();
        plugins
            .filter_map(|setup| Some((setup.name.clone(), serde_json::to_string(&setup.description).ok()?)))
            .collect()
    }

    /// The attachments that are texts: name, media type and content.
    fn texts(&self) -> impl Iterator<Item = (Cow<'static, str>, &'static str, &str)> {
        let texts = [
            ("mission.toml", "application/toml", Some(self.resolved_mission)),
            ("fence.geojson", "application/geo+json", Some(self.fence)),
            ("world.toml", "application/toml", self.world),
            (PLAN, "application/toml", self.sources.plan),
        ];
        let texts = texts
            .into_iter()
            .filter_map(|(name, media_type, text)| Some((Cow::Borrowed(name), media_type, text?)));
        let fence = self.sources.fence.map(|(name, text)| {
            let name = Cow::Owned(format!("{AS_READ}{name}"));
            (name, "text/plain", text)
        });
        texts.chain(fence)
    }
}

/// What each part of a log begins with.
#[derive(Debug)]
pub(crate) struct Preamble {
    metadata: [Metadata; 3],
    /// Name, media type and content.
    texts: Vec<(String, &'static str, String)>,
    /// UTC at the run's time zero, nanoseconds since 1970.
    time_ns: u64,
    part: u64,
}

impl Preamble {
    pub(crate) fn of(header: &Header<'_>) -> Self {
        let metadata = [
            (RUN, header.run()),
            (COMPONENTS, header.component_hashes()),
            (DESCRIPTIONS, header.descriptions()),
        ];
        let texts = header.texts();
        Self {
            metadata: metadata.map(|(name, metadata)| Metadata {
                name: name.to_owned(),
                metadata,
            }),
            texts: texts
                .map(|(name, media_type, text)| (name.into_owned(), media_type, text.to_owned()))
                .collect(),
            time_ns: header.utc_at_start.as_unix_nanos(),
            part: 1,
        }
    }

    pub(crate) fn next_part(&mut self) {
        self.part += 1;
        let [run, ..] = &mut self.metadata;
        run.metadata.insert(PART.to_owned(), self.part.to_string());
    }

    pub(crate) const fn metadata(&self) -> &[Metadata] {
        &self.metadata
    }

    /// The texts, and those of these components that are not too large.
    pub(crate) fn attachments<'a>(
        &'a self,
        components: impl IntoIterator<Item = (&'a String, &'a [u8])>,
    ) -> impl Iterator<Item = mcap::Attachment<'a>> {
        let attachment = |name: String, media_type: &str, data: &'a [u8]| mcap::Attachment {
            log_time: self.time_ns,
            create_time: self.time_ns,
            name,
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(data),
        };
        let texts = self.texts.iter();
        let texts = texts.map(move |(name, media_type, text)| attachment(name.clone(), media_type, text.as_bytes()));
        let components = components
            .into_iter()
            .filter(|(_, component)| component.len() <= COMPONENT_LIMIT);
        texts.chain(
            components.map(move |(name, component)| attachment(component_name(name), "application/wasm", component)),
        )
    }
}

/// The name of the attachment of a version that took a plugin's place in mid-run.
pub(crate) fn version_name(sha256: &str) -> String {
    format!("components/{sha256}.wasm")
}

pub(crate) fn component_name(plugin: &str) -> String {
    format!("components/{plugin}.wasm")
}

fn sha256(data: &[u8]) -> String {
    Sha256::digest(data)
        .iter()
        .fold(String::with_capacity(64), |mut hex, byte| {
            write!(hex, "{byte:02x}").expect("a String takes everything");
            hex
        })
}
