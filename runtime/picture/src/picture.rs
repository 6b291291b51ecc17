use backseat_units::EastNorth;

/// The contents of a picture. Everything but the title may be empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Shown in large letters.
    pub title: String,
    /// Shown below the title.
    pub subtitle: String,
    /// Values of the run, shown below the map; long text is wrapped.
    pub caption: String,
    /// What the view must contain. If `None`, everything that is drawn except the ground.
    pub extent: Option<Extent>,
    /// The ground under everything.
    pub ground: Option<Raster>,
    /// The fence's zones.
    pub zones: Vec<Zone>,
    /// The front seat's plan, drawn dashed.
    pub planned: Vec<EastNorth>,
    /// The track, oldest first.
    pub flown: Vec<TrackPoint>,
    /// Inserts that were accepted.
    pub inserts: Vec<Shape>,
    /// Requests that were refused.
    pub rejected: Vec<Rejected>,
    /// The points where leases began.
    pub lease_begins: Vec<EastNorth>,
    /// The points where leases ended.
    pub lease_ends: Vec<EastNorth>,
    /// Who asked for what is drawn.
    pub payload: Payload,
}

/// Who asks the vehicle for something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Payload {
    /// A plugin.
    #[default]
    Plugin,
    /// A client of the vehicle, whatever it is.
    Client,
}

/// A rectangle of the frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// The west edge.
    pub west_m: f64,
    /// The south edge.
    pub south_m: f64,
    /// The east edge.
    pub east_m: f64,
    /// The north edge.
    pub north_m: f64,
}

/// A quantity over the area, drawn in filled bands with contour lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// The rectangle of the outermost nodes.
    pub extent: Extent,
    /// The number of nodes from west to east, at least 2.
    pub width: usize,
    /// The number of nodes from south to north, at least 2.
    pub height: usize,
    /// `width * height` values: rows from the south, each row from the west. A value that is not finite is a hole.
    pub values: Vec<f64>,
    /// Its name, such as `seabed depth`.
    pub label: String,
    /// Its unit, such as `m`.
    pub unit: String,
    /// Its colours.
    pub palette: Palette,
    /// A value whose contour is drawn with a strong line: the isobath to follow.
    pub highlight: Option<f64>,
}

/// The colours of a raster.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Palette {
    /// Blue, darker for greater values; for depth.
    #[default]
    Depth,
    /// Blue for small values, red for great ones; for what is measured in the water, where high is warm.
    Field,
}

/// A zone of the fence.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// The name written beside it.
    pub name: String,
    /// Whether the vehicle must stay inside or outside.
    pub kind: ZoneKind,
    /// Outer ring and holes; the first point may be repeated at the end.
    pub rings: Vec<Vec<EastNorth>>,
    /// The distance to keep from the edge, metres, on the side where the vehicle may be.
    pub margin_m: f64,
}

/// What a zone requires.
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
    /// The position.
    pub at: EastNorth,
    /// Who steered from here on.
    pub steer: Steer,
}

/// Who steers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Steer {
    /// The vehicle's own mission.
    FrontSeat,
    /// A payload, by a lease.
    Modify,
    /// The vehicle, flying a payload's insert.
    Insert,
}

/// The geometry of a request.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A position.
    Point(EastNorth),
    /// A straight line: a trackline, or the path that a modify would have taken.
    Line(EastNorth, EastNorth),
    /// A circle to fly.
    Circle {
        /// Its centre.
        centre: EastNorth,
        /// The radius, metres.
        radius_m: f64,
    },
}

/// A request that was refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejected {
    /// The requested geometry.
    pub shape: Shape,
    /// The reason in a few words. Requests with the same reason share one label.
    pub reason: String,
}
