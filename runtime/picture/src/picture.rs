use backseat_units::EastNorth;

/// What a picture shows. Everything but the title may be empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// In large letters.
    pub title: String,
    /// Below it.
    pub subtitle: String,
    /// Figures of the run, below the map; long ones are wrapped.
    pub caption: String,
    /// What is in view at least; `None`: all that is drawn, the ground left out.
    pub extent: Option<Extent>,
    /// The ground under everything.
    pub ground: Option<Raster>,
    /// The fence.
    pub zones: Vec<Zone>,
    /// The front seat's plan, dashed.
    pub planned: Vec<EastNorth>,
    /// The track, oldest first.
    pub flown: Vec<TrackPoint>,
    /// Inserts that were accepted.
    pub inserts: Vec<Shape>,
    /// Requests that were refused.
    pub rejected: Vec<Rejected>,
    /// Where leases began.
    pub lease_begins: Vec<EastNorth>,
    /// Where they ended.
    pub lease_ends: Vec<EastNorth>,
}

/// A rectangle of the frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Least east.
    pub west_m: f64,
    /// Least north.
    pub south_m: f64,
    /// Greatest east.
    pub east_m: f64,
    /// Greatest north.
    pub north_m: f64,
}

/// A scalar over the ground, drawn in filled bands with contour lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Where the outermost nodes are.
    pub extent: Extent,
    /// Nodes from west to east, at least 2.
    pub width: usize,
    /// Nodes from south to north, at least 2.
    pub height: usize,
    /// `width * height` values, rows from the south, each from the west. What is not finite is a hole.
    pub values: Vec<f64>,
    /// What it is, such as `seabed depth`.
    pub label: String,
    /// Its unit, such as `m`.
    pub unit: String,
    /// Its colours.
    pub palette: Palette,
    /// A value whose contour is drawn strongly: the isobath that was sought.
    pub highlight: Option<f64>,
}

/// Colours of a raster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Palette {
    /// Blues, darker where the value is greater: depth.
    #[default]
    Depth,
    /// Yellow to green, darker where the value is greater: any other field.
    Field,
}

/// A zone of the fence.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// Written beside it.
    pub name: String,
    /// To stay in, or to stay out of.
    pub kind: ZoneKind,
    /// Outer ring and holes; closing points may be repeated or not.
    pub rings: Vec<Vec<EastNorth>>,
    /// How far from the edge the vehicle is kept, metres, on the side where it may be.
    pub margin_m: f64,
}

/// What a zone demands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneKind {
    /// Stay inside.
    KeepIn,
    /// Stay outside.
    KeepOut,
}

/// A point of the track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackPoint {
    /// Where.
    pub at: EastNorth,
    /// Who steered from here on.
    pub steer: Steer,
}

/// Who steers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steer {
    /// The vehicle's own mission.
    FrontSeat,
    /// A plugin, by a lease.
    Modify,
    /// The vehicle, flying a plugin's insert.
    Insert,
}

/// The geometry of a request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A place.
    Point(EastNorth),
    /// From here to there: a trackline, or where a modify would have led.
    Line(EastNorth, EastNorth),
    /// A circle to fly.
    Circle {
        /// Its centre.
        centre: EastNorth,
        /// Metres.
        radius_m: f64,
    },
}

/// A request that was refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejected {
    /// What it asked for.
    pub shape: Shape,
    /// Why not, in a few words. Equal reasons share one label.
    pub reason: String,
}
