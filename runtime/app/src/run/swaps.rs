//! Takes the operator's orders for other versions of plugins, and makes them ready on a thread of its own: compiling may
//! take seconds, and the loop waits for nothing.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use backseat_core::PluginSetup;
use backseat_core::plugin::{PluginId, Version};
use backseat_lock::sha256;
use backseat_mission::Mission;
use backseat_plugin_host::{COMPONENT_BYTES, Host, Plugin};
use backseat_plugin_loader::Components;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tracing::warn;

use crate::aside;
use crate::lock::Allowed;
use crate::swap::{Answer, FOLDER, Files, OPEN_FOLDER, Order, is_open, place};

const LOOK_EVERY: Duration = Duration::from_millis(500);
/// The largest order, bytes.
const ORDER_BYTES: u64 = 4096;

/// A version that is ready to take a plugin's place.
pub(crate) struct Offer {
    pub(crate) plugin: PluginId,
    pub(crate) ready: Plugin,
    pub(crate) version: Version,
    pub(crate) component: Vec<u8>,
    number: u64,
}

/// What the thread tells the loop.
pub(crate) enum News {
    /// A version is ready.
    Ready(Box<Offer>),
    /// An order was refused; the text says why.
    Refused(String),
}

/// What the thread works with.
struct Desk {
    folder: PathBuf,
    host: Host,
    mission: Arc<Mission>,
    setups: Vec<PluginSetup>,
    allowed: Option<Allowed>,
}

/// An answer to leave for the operator.
struct Told {
    plugin: PluginId,
    answer: Answer,
}

/// The loop's side.
pub(crate) struct Swaps {
    news: UnboundedReceiver<News>,
    told: Sender<Told>,
    /// The order of each plugin whose version is about to take over.
    open: Vec<Option<(u64, Version)>>,
}

impl Swaps {
    /// Starts the thread. With `allowed`, only these components may take a plugin's place.
    ///
    /// # Errors
    /// If it cannot start.
    pub(crate) fn start(
        state: &Path,
        host: Host,
        mission: Arc<Mission>,
        setups: &[PluginSetup],
        allowed: Option<Allowed>,
    ) -> Result<Self> {
        let (telling, news) = unbounded_channel();
        let (told, answers) = channel();
        let desk = Desk {
            folder: state.join(FOLDER),
            host,
            mission,
            setups: setups.to_vec(),
            allowed,
        };
        aside::spawn("swap", move || desk.serve(&telling, &answers))?;
        Ok(Self {
            news,
            told,
            open: setups.iter().map(|_| None).collect(),
        })
    }

    /// What the thread says next; waits for ever where there will be nothing.
    pub(crate) async fn next(swaps: &mut Option<Self>) -> News {
        if let Some(Self { news, .. }) = swaps {
            if let Some(said) = news.recv().await {
                return said;
            }
            // The thread has panicked.
            *swaps = None;
        }
        std::future::pending().await
    }

    /// The loop has this offer, and core knows of it.
    pub(crate) fn taken(&mut self, offer: &Offer) {
        let Offer {
            plugin,
            version,
            number,
            ..
        } = offer;
        if let Some((number, _)) = self.open[plugin.0].replace((*number, version.clone())) {
            self.tell(
                *plugin,
                number,
                false,
                "another order came before this one was carried out".to_owned(),
            );
        }
    }

    /// A version took over, or did not: `failed` says why.
    pub(crate) fn ended(&mut self, plugin: PluginId, name: &str, failed: Option<&str>) {
        let Some((number, version)) = self.open.get_mut(plugin.0).and_then(Option::take) else {
            return;
        };
        let text = match failed {
            None => format!("{name}: version {version}, steps now"),
            Some(why) => format!("{name}: not swapped, the version before goes on: {why}"),
        };
        self.tell(plugin, number, failed.is_none(), text);
    }

    fn tell(&self, plugin: PluginId, number: u64, swapped: bool, text: String) {
        let answer = Answer { number, swapped, text };
        // The thread may have panicked; the screen and the log say it too.
        let _gone = self.told.send(Told { plugin, answer });
    }
}

impl Desk {
    fn serve(&self, news: &UnboundedSender<News>, answers: &Receiver<Told>) {
        // What an earlier process has not carried out is not carried out by this one.
        for setup in &self.setups {
            let files = Files::of(&self.folder, &setup.name);
            if fs::remove_file(files.order()).is_ok() {
                warn!(
                    "{}: an order to swap that an earlier run has not carried out is dropped",
                    setup.name
                );
            }
            let _none = files.clear();
        }
        let at_work = Files::at_work(&self.folder);
        let _none = fs::remove_file(&at_work);
        // Where the folder cannot be read, that is told once.
        let mut ignored: Vec<Option<String>> = self.setups.iter().map(|_| None).collect();
        loop {
            crate::clock::pause(LOOK_EVERY);
            if news.is_closed() {
                return;
            }
            while let Ok(Told { plugin, answer }) = answers.try_recv() {
                self.answer(&self.setups[plugin.0].name, &answer);
            }
            self.refuse_others();
            for (index, setup) in self.setups.iter().enumerate() {
                let taken = self.take(&setup.name);
                let before = ignored[index].take();
                match taken {
                    Ok(None) => {}
                    Err(error) => {
                        let text = format!("{}: order to swap ignored: {error:#}", setup.name);
                        if before.as_ref() != Some(&text) {
                            warn!("{text}");
                            let _ended = news.send(News::Refused(text.clone()));
                        }
                        ignored[index] = Some(text);
                    }
                    Ok(Some(order)) => {
                        let number = order.number;
                        // Without this file a command that waits longer thinks that we are stuck.
                        let _told = place(&at_work, setup.name.as_bytes());
                        let component = self.component(&setup.name, number);
                        let prepare = |component| self.prepare(PluginId(index), setup, order, component);
                        match component.and_then(prepare) {
                            // The loop may have ended.
                            Ok(offer) => drop(news.send(News::Ready(Box::new(offer)))),
                            Err(error) => {
                                let text = format!("{}: not swapped: {error:#}", setup.name);
                                warn!("{text}");
                                let _ended = news.send(News::Refused(text.clone()));
                                let swapped = false;
                                self.answer(&setup.name, &Answer { number, swapped, text });
                            }
                        }
                        let _none = fs::remove_file(&at_work);
                    }
                }
            }
        }
    }

    /// Refuses the orders for plugins that the mission does not have: whoever gave them has named another mission.
    fn refuse_others(&self) {
        let names: Vec<&str> = self.setups.iter().map(|setup| setup.name.as_str()).collect();
        for entry in fs::read_dir(&self.folder).into_iter().flatten().flatten() {
            let file = entry.file_name();
            let Some(plugin) = file.to_str().and_then(|name| name.strip_suffix(".order")) else {
                continue;
            };
            if names.contains(&plugin) {
                continue;
            }
            if let Ok(Some(Order { number, .. })) = self.take(plugin) {
                let _none = fs::remove_file(Files::of(&self.folder, plugin).component(number));
                let mission = &self.mission.name;
                let names = names.join(", ");
                let text = format!("{plugin}: not swapped: the runtime flies {mission}, whose plugins are: {names}");
                warn!("{text}");
                let swapped = false;
                self.answer(plugin, &Answer { number, swapped, text });
            }
        }
    }

    fn answer(&self, plugin: &str, answer: &Answer) {
        let left = toml::to_string(answer).map_err(anyhow::Error::from);
        let left = left.and_then(|text| place(&Files::of(&self.folder, plugin).answer(answer.number), text.as_bytes()));
        if let Err(error) = left {
            warn!("{plugin}: the answer to the operator cannot be left: {error:#}");
        }
    }

    /// The next order for a plugin, if there is one. It is removed.
    fn take(&self, plugin: &str) -> Result<Option<Order>> {
        let path = Files::of(&self.folder, plugin).order();
        match fs::symlink_metadata(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(error).context(path.display().to_string()),
            Ok(found) if !found.is_file() || found.len() > ORDER_BYTES => {
                fs::remove_file(&path)?;
                bail!("{}: this is no order", path.display());
            }
            Ok(_) => {}
        }
        let text = fs::read_to_string(&path);
        match fs::remove_file(&path) {
            // The command has withdrawn it.
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            removed => removed.with_context(|| path.display().to_string())?,
        }
        ensure!(!is_open(&self.folder)?, "{}: {OPEN_FOLDER}", self.folder.display());
        Ok(Some(toml::from_str(&text?).context("it cannot be read")?))
    }

    /// The component of an order. It is removed.
    fn component(&self, plugin: &str, number: u64) -> Result<Vec<u8>> {
        let path = Files::of(&self.folder, plugin).component(number);
        let found = fs::symlink_metadata(&path).with_context(|| path.display().to_string())?;
        ensure!(
            found.is_file() && found.len() <= COMPONENT_BYTES as u64,
            "{}: expected a file of at most {COMPONENT_BYTES} bytes",
            path.display()
        );
        let component = fs::read(&path).with_context(|| path.display().to_string())?;
        let _read = fs::remove_file(&path);
        Ok(component)
    }

    fn prepare(&self, plugin: PluginId, setup: &PluginSetup, order: Order, component: Vec<u8>) -> Result<Offer> {
        let Order {
            number,
            sha256: named,
            trial_steps,
        } = order;
        let hash = sha256(&component);
        ensure!(hash == named, "the component is not the one whose hash was named");
        if let Some(allowed) = &self.allowed {
            allowed.check(&setup.name, &hash)?;
        }
        let mut components = Components::new();
        components.insert_file(&self.host, &hash, &setup.name, PathBuf::from(&hash[..12]), &component)?;
        let table = &self.mission.file.plugins[plugin.0];
        let started = components.start_described(&hash, table, &self.mission)?;
        let (now, new) = (&setup.description, &started.description);
        ensure!(
            now.step_period == new.step_period,
            "it wants a step each {:?}, and the version that the run began with each {:?}: only a new run can change that",
            new.step_period,
            now.step_period
        );
        ensure!(
            now.topics == new.topics,
            "it wants the topics {:?}, and the version that the run began with {:?}: only a new run can change that",
            new.topics,
            now.topics
        );
        Ok(Offer {
            plugin,
            version: Version {
                version: new.version.clone(),
                sha256: hash,
                trial_steps,
            },
            ready: started.plugin,
            component,
            number,
        })
    }
}
