use std::sync::LazyLock;

/// What becomes of a field on its way into the fingerprint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    /// It is left out.
    Leave,
    /// A request's number counts as the place where it was met first: which requests are the same is told, which numbers
    /// they have is not.
    Request,
    /// An SPI identifier, in the same way.
    Identifier,
    /// A plugin's own name for a request, in the same way.
    Tag,
    /// Metres, in cells of 250 m around the origin: the vehicle moves 1 m a second, and the fence's edges are further.
    Cell,
    /// Seconds on core's clock, as a number: how long ago.
    SecondsAgo,
    /// To the thousandth.
    Thousandth,
    /// Degrees, to the tenth.
    Tenth,
    /// A time that is longer ago than so many seconds is as long ago as any other.
    Within(u64),
}

/// A field that does not go into the fingerprint as it is.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// The type, as the code names it.
    pub of: &'static str,
    /// The field; of an enum the variant that has one value, or a field of a variant.
    pub field: &'static str,
    /// What becomes of it.
    pub treatment: Treatment,
    /// Why nothing is lost by it.
    pub why: &'static str,
}

macro_rules! rules {
    ($($of:ident: $treatment:expr => [$($field:ident)*] $why:literal;)*) => {
        /// All rules, by type.
        pub const RULES: &[Rule] = &[$($(Rule {
            of: stringify!($of),
            field: stringify!($field),
            treatment: $treatment,
            why: $why,
        },)*)*];
    };
}

use Treatment as T;

rules! {
    Arbiter: T::Leave => [steered] "the mission caps no plugin's steering";
    Begin: T::Cell => [within_m] "it is of the place";
    Command: T::Identifier => [identifier] "which insert a command is about, whatever its number";
    Context: T::Leave => [now] "when core was called last: the next call has a time of its own";
    Core: T::Leave => [late_count flaw_told] "a count that is only read out, and a line for people";
    EastNorth: T::Cell => [east_m north_m] "the vehicle moves all the time";
    Element: T::Identifier => [identifier] "which insert, whatever its number";
    Entry: T::Cell => [duration_s] "it follows from the place, in seconds: far from the mission's cap";
    Entry: T::Tag => [tag] "which request, whatever the plugin calls it";
    Entry: T::Identifier => [identifier] "which insert, whatever its number";
    Excursion: T::Leave => [refusal] "it is told, and follows from the place";
    Flown: T::Identifier => [Inserted] "which insert, whatever its number";
    Good: T::Cell => [clearance_m] "it follows from the place";
    Helm: T::Leave => [since] "the mission caps no plugin's steering";
    Identifiers: T::Leave => [reserved inserts_sent gps_hits_sent] "counters: the next numbers, far from the mission's caps";
    Identifiers: T::Identifier => [sent] "which inserts, whatever their numbers";
    Keeping: T::Request => [request] "which request, whatever its number";
    Lease: T::Request => [request] "which request, whatever its number";
    Ledger: T::Leave => [last orders counts] "request numbers and counts";
    Ledger: T::Request => [open doubtful refused recalled] "which requests, whatever their numbers";
    Mark: T::Tenth => [heading_off_deg] "which way the UTM grid lies changes as the vehicle moves";
    Mark: T::SecondsAgo => [at_s] "a time";
    Integrity: T::Leave => [limits slope_max] "the mission's";
    Integrity: T::SecondsAgo => [frozen_since_s] "a time";
    NamedInsert: T::Identifier => [current before] "which insert, whatever its number";
    Modify: T::Within(1) => [sent] "no BPRMB within 0.2 s of the last, and nothing else";
    NavigationSample: T::Tenth => [heading] "which way the UTM grid lies changes as the vehicle moves";
    NavigationSample: T::Leave => [position] "the same as its place in the fence's frame";
    Outbox: T::Leave => [vehicle_lines] "how many lines for people may yet be written";
    Plan: T::Leave => [lost] "the count of lines that were cut short: here none is";
    PreviousRun: T::Identifier => [still_flown_after_end left surfacing cancelled] "which insert, whatever its number";
    Purpose: T::Request => [Lease Insert Station Topside cancel insert] "which request, whatever its number";
    Recall: T::Identifier => [identifier] "which insert, whatever its number";
    Recalls: T::Request => [open] "which requests, whatever their numbers";
    Session: T::Leave => [lost jitter malformed clock_told control_notes] "counts, the seed of the back-off's jitter, lines for people";
    Slot: T::Leave => [over_rate inserts_sent] "lines for people, and a counter that the mission does not cap";
    Slot: T::Leave => [requests messages] "it asks once a second, and may twenty times";
    Slot: T::Leave => [events] "what it will be told: it asks what the exploration has it ask";
    Stamper: T::Leave => [last] "stamps: no two sentences of a name have the same";
    Sum: T::Cell => [down_m] "it is only held against an earlier one";
    Sum: T::SecondsAgo => [at_s] "a time";
    Tracker: T::Within(11) => [steady_since jumped_at] "navigation is steady after ten seconds";
    Waiting: T::Tag => [tag] "which request, whatever the plugin calls it";
    Waiting: T::Request => [request] "which request, whatever its number";
    // What is around core.
    Ack: T::Identifier => [identifier] "which insert, whatever its number";
    Flies: T::Identifier => [Insert] "which insert, whatever its number";
    Front: T::Identifier => [queue] "which inserts, whatever their numbers";
    Judge: T::Leave => [used ended] "numbers that were used: core draws each from a counter that is left out too";
    Judge: T::Identifier => [inserts listed to_cancel] "which inserts, whatever their numbers";
    Judge: T::Within(1) => [last_modify] "no BPRMB within 0.2 s of the last, and nothing else";
    Judge: T::Within(4) => [solved solution answered] "both are too old after three";
    Judge: T::Within(11) => [moved] "navigation is steady after ten seconds";
    Judge: T::Thousandth => [place] "the vehicle moves all the time: a thousandth of a degree is 100 m";
    World: T::Leave => [tags] "a counter";
    World: T::Tag => [newest] "which request, whatever the plugin calls it";
}

/// How many buckets the types are looked up in.
const BUCKETS: usize = 128;

/// Where the rules of a type begin and end in [`RULES`].
type Span = (&'static str, usize, usize);

static BY_TYPE: LazyLock<[Vec<Span>; BUCKETS]> = LazyLock::new(|| {
    let mut buckets = [const { Vec::new() }; BUCKETS];
    let mut first = 0;
    for rules in RULES.chunk_by(|one, next| one.of == next.of) {
        let last = first + rules.len();
        buckets[bucket(rules[0].of)].push((rules[0].of, first, last));
        first = last;
    }
    buckets
});

fn bucket(name: &str) -> usize {
    let first = name.as_bytes().first().copied().unwrap_or_default();
    (usize::from(first) * 5 + name.len()) % BUCKETS
}

/// The rules of a type, which stand together, and the place of the first.
pub(super) fn of(name: &str) -> (usize, &'static [Rule]) {
    let span = BY_TYPE[bucket(name)].iter().find(|(of, ..)| *of == name);
    span.map_or((0, &[]), |(_, first, last)| (*first, &RULES[*first..*last]))
}
