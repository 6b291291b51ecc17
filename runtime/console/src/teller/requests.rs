use serde_json::Value;

use super::{ByName, words};
use crate::item::{Counts, Item};

/// Follows the states of requests.
#[derive(Debug, Default)]
pub(super) struct Requests {
    all: Counts,
    by: ByName<Counts>,
    told: (Counts, f64),
    /// Whose modify was sent last.
    leads: Option<String>,
}

impl Requests {
    /// Takes a message of `/requests`. Of modifies only what went wrong makes an item, because there are some each second.
    pub(super) fn transition(&mut self, value: &Value, name: impl Fn(usize) -> Option<String>) -> Option<Item> {
        let kind = value["kind"].as_str()?;
        let state = value["state"].as_str()?;
        let plugin = value["plugin"].as_u64().and_then(|plugin| usize::try_from(plugin).ok());
        let owner = match value["owner"].as_str()? {
            "plugin" => plugin.and_then(name).unwrap_or_else(|| "plugin".to_owned()),
            other => other.to_owned(),
        };
        let of_owner = self.by.entry(owner.clone()).or_default();
        for counts in [&mut self.all, of_owner] {
            match state {
                "rejected" => counts.rejected += 1,
                "sent" => counts.sent += 1,
                "accepted" => counts.accepted += 1,
                "failed" | "timed-out" => counts.failed += 1,
                _ => {}
            }
        }
        let steers = matches!(kind, "modify" | "station");
        if steers && state == "sent" {
            self.leads = Some(owner.clone());
        }
        let wrong = matches!(state, "rejected" | "failed" | "timed-out" | "unknown");
        if kind == "modify" && !wrong {
            return None;
        }
        Some(Item::Request {
            request: value["request"].as_u64()?,
            owner,
            request_kind: kind.to_owned(),
            state: state.to_owned(),
            tag: value["tag"].as_u64(),
            reason: words(&value["reason"]),
            identifier: value["identifier"].as_u64(),
        })
    }

    /// Whose modify was sent last.
    pub(super) fn leads(&self) -> Option<&str> {
        self.leads.as_deref()
    }

    /// The counts, if they have changed and a second has passed.
    pub(super) fn counts(&mut self, t: f64) -> Option<Item> {
        let (before, due) = self.told;
        if self.all == before || t < due {
            return None;
        }
        self.told = (self.all, t + 1.0);
        Some(Item::Counts {
            all: self.all,
            by: self.by.clone(),
        })
    }
}
