//! What core sends, sentence by sentence.

use std::time::Duration;

use backseat_units::Timestamp;

use super::{Insert, Judge, MODIFY_GAP, STATION_GAP, STEADY, Stage, Unanswered};
use crate::course;
use crate::wire::Line;

/// What may be said without control (SR-014). BPSPD is there for the speed limit that the end of station keeping gives back.
const LIST: [&str; 11] = [
    "VER", "LOG", "STS", "MSG", "RMP", "RCN", "EMB", "RES", "SPD", "DVR", "TMR",
];
/// What takes the vehicle elsewhere, or keeps it from going on.
const STEERS: [&str; 8] = ["RMB", "RTK", "RTC", "RGP", "SUS", "CON", "GHP", "GBP"];
/// No answer is awaited for longer.
const FORGOTTEN: Duration = Duration::from_secs(10);
/// A modify may stand for so long without a word of ours (SPI 7.12).
const LAPSES_S: f64 = 5.0;
const METRES_A_DEGREE: f64 = 111_100.0;

impl Judge {
    /// A sentence of core's leaves.
    pub(crate) fn sent(&mut self, now: Timestamp, line: &Line<'_>) {
        let command = &line.name[2..];
        self.unanswered.retain(|command| now.since(command.sent) < FORGOTTEN);
        self.unanswered.push(Unanswered {
            command: command.to_owned(),
            created: if command == "LOG" {
                String::new()
            } else {
                line.field(0).to_owned()
            },
            sent: now,
        });
        self.expect(line.name.starts_with("BP"), "SR-013 words", || line.name.to_owned());
        self.expect(!matches!(command, "ABT" | "KIL"), "SR-012 abort", || {
            format!("BP{command} that nobody has ordered")
        });
        let allowed = LIST.contains(&command) || self.has_control();
        let state = self.state();
        self.expect(allowed, "SR-001 control", || format!("BP{command} leaves {state}"));
        if STEERS.contains(&command) {
            self.steers(now, command);
        }
        match command {
            "RMB" => self.modifies(now, line),
            "EMB" => {
                let ends = self.modified.take().is_some();
                self.expect(ends, "SR-003 one BPEMB", || "a BPEMB that ends nothing".to_owned());
            }
            "SUS" => {
                let modified = self.modified.is_some();
                self.expect(!modified, "SR-005 one helm", || "BPSUS under a modify".to_owned());
                self.suspended = Some(now);
            }
            "CON" | "GHP" | "GBP" => {
                let gap = self.suspended.map(|last| now.since(last));
                let kept = gap.is_some_and(|gap| gap <= STATION_GAP);
                self.expect(kept, "SR-005 station gap", || {
                    format!("BP{command} {gap:?} after the last word")
                });
                self.suspended = Some(now);
            }
            "RES" => {
                let ends = self.suspended.take().is_some();
                self.expect(ends, "SR-005 one BPRES", || "a BPRES that ends nothing".to_owned());
            }
            "RTK" => self.inserts(line),
            "RCN" => {
                if let Some(identifier) = line.number::<u32>(1) {
                    self.to_cancel.remove(&identifier);
                    if let Some(insert) = self.inserts.get_mut(&identifier) {
                        insert.taken_back = true;
                    }
                }
                let ours = line.number(1).is_some_and(|identifier: u32| self.is_ours(identifier));
                self.expect(ours, "SR-014 own inserts", || {
                    format!("BPRCN {} is not ours", line.field(1))
                });
            }
            _ => {}
        }
    }

    fn is_ours(&self, identifier: u32) -> bool {
        // A previous process may have sent what is below the first of this one.
        self.used.contains(&identifier) || self.used.first().is_none_or(|first| identifier < *first)
    }

    fn state(&self) -> String {
        let known = |what: Option<bool>| match what {
            Some(true) => "yes",
            Some(false) => "no",
            None => "unknown",
        };
        format!(
            "with the link {}, control given: {}, mission running: {}, held: {}",
            if self.up { "up" } else { "down" },
            known(self.control),
            known(self.running),
            self.held
        )
    }

    /// What holds for all that steers.
    fn steers(&mut self, now: Timestamp, command: &str) {
        let held = self.held;
        self.expect(!held, "SR-015 hold", || {
            format!("BP{command} leaves under the operator's hold")
        });
        let age = self.age(now);
        let fresh = age.is_some_and(|age| age <= Duration::from_secs_f64(course::AGE_MAX_S));
        self.expect(fresh, "SR-008 stale navigation", || {
            format!("BP{command} leaves on navigation {age:?} old")
        });
        let trip = self.answered.map(|sent| now.since(sent));
        let heard = trip.is_some_and(|ago| ago < Duration::from_secs(3));
        self.expect(heard, "SR-023 unheard", || {
            format!("BP{command} leaves, and the newest good round trip began {trip:?} ago")
        });
        let jumped = self.moved.map(|moved| now.since(moved));
        let steady = jumped.is_none_or(|ago| ago >= STEADY);
        self.expect(steady, "SR-021 jump", || {
            format!("BP{command} leaves {jumped:?} after a jump")
        });
        let planned = self.planned || !matches!(command, "RMB" | "RTK");
        self.expect(planned, "SR-025 plan", || {
            format!("BP{command} leaves, and the plan of this dive has not come on this connection")
        });
    }

    fn modifies(&mut self, now: Timestamp, line: &Line<'_>) {
        let suspended = self.suspended.is_some();
        self.expect(!suspended, "SR-005 one helm", || {
            "BPRMB under station keeping".to_owned()
        });
        if let Some(last) = self.last_modify {
            let gap = now.since(last);
            self.expect(gap >= Duration::from_millis(200), "SR-019 modify rate", || {
                format!("BPRMB {gap:?} after the last")
            });
        }
        if let Some(last) = self.modified {
            let gap = now.since(last);
            self.expect(gap <= MODIFY_GAP, "SR-003 lease gap", || {
                format!("BPRMB {gap:?} after the last")
            });
        }
        let over = self.term.is_none_or(|term| now >= term);
        self.expect(!over, "SR-003 lease term", || {
            "BPRMB after the term that was asked for".to_owned()
        });
        self.modified = Some(now);
        self.last_modify = Some(now);
        // Straight ahead for as long as the vehicle goes on without a word; the lead north is all that can leave.
        let (heading_deg, speed_mps): (f64, f64) =
            (line.number(1).unwrap_or(f64::NAN), line.number(4).unwrap_or(f64::NAN));
        let north = if heading_deg < 45.0 {
            speed_mps * LAPSES_S / METRES_A_DEGREE
        } else {
            0.0
        };
        let ends_inside = self
            .place
            .is_some_and(|[latitude, longitude]| inside([latitude + north, longitude]));
        self.expect(ends_inside, "SR-002 modify outside", || {
            format!("BPRMB towards {heading_deg} at {speed_mps} m/s leads out of the fence within 5 s")
        });
    }

    fn inserts(&mut self, line: &Line<'_>) {
        let identifier: u32 = line.number(1).unwrap_or(0);
        let reserved = self.reserved;
        self.expect(identifier < reserved, "SR-009 reserved", || {
            format!("identifier {identifier} is not reserved on disk")
        });
        let fresh = self.used.insert(identifier) && !self.inserts.contains_key(&identifier);
        self.expect(fresh, "SR-009 identifiers", || {
            format!("identifier {identifier} is used twice")
        });
        let asked = self.asked > 0;
        self.expect(asked, "SR-009 sent once", || {
            format!("insert {identifier} leaves, and the plugin has asked for none that has not left")
        });
        self.asked = self.asked.saturating_sub(1);
        let ends = [line.place(2), line.place(6)];
        let is_inside = ends.iter().all(|end| end.is_some_and(inside));
        self.expect(is_inside, "SR-002 insert outside", || {
            format!("insert {identifier} leaves the fence")
        });
        // What was sent and is not answered on the connection that is up is another thing: it may be called back.
        let doubtful = self.inserts.iter().find(|(_, insert)| insert.stage == Stage::Doubtful);
        let doubtful = doubtful.map(|(identifier, _)| *identifier);
        self.expect(doubtful.is_none(), "SR-009 doubt", || {
            format!("insert {identifier} leaves while {doubtful:?} is in doubt")
        });
        let interrupts = line.field(14) == "4";
        let interrupted = self.inserts.values().any(|insert| insert.interrupts);
        self.expect(!(interrupts && interrupted), "SR-010 interrupt of an interrupt", || {
            format!("insert {identifier} interrupts while one that interrupts is open")
        });
        let open = self.inserts.len() + 1;
        self.expect(open <= course::OPEN_MAX as usize, "SR-019 open inserts", || {
            format!("insert {identifier} is the {open}. that is open")
        });
        let insert = Insert {
            interrupts,
            stage: Stage::Sent,
            taken_back: false,
        };
        self.inserts.insert(identifier, insert);
    }
}

fn inside([latitude, longitude]: [f64; 2]) -> bool {
    let [south, north, west, east] = course::EDGES_DEG;
    (south..=north).contains(&latitude) && (west..=east).contains(&longitude)
}
