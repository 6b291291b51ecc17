//! KML whose misspelt or misplaced parts would make the fence laxer is refused; what real programs write is read.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use backseat_fence::{Fence, Terms};

const TERMS: Terms = Terms {
    margin_m: 10.0,
    depth_min_m: 2.0,
    depth_max_m: 30.0,
    altitude_min_m: 3.0,
    surfacing: true,
};

/// A document with a line for each part that the tests replace.
const KML: &str = r#"<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">
<Document>
<Folder>
<Placemark>
<name>box</name>
<TimeSpan><begin>2026-05-01T08:00:00Z</begin></TimeSpan>
<ExtendedData>
<Data name="kind"><value>keep-in</value></Data>
<Data name="margin_m"><displayName>Margin</displayName><value>90</value></Data>
<SchemaData><SimpleData name="surfacing">false</SimpleData></SchemaData>
</ExtendedData>
<Polygon>
<outerBoundaryIs><LinearRing><coordinates>
-70.0,42.0 -69.98,42.0 -69.98,42.02 -70.0,42.02 -70.0,42.0
</coordinates></LinearRing></outerBoundaryIs>
<innerBoundaryIs><LinearRing><coordinates>-69.99,42.012 -69.988,42.012 -69.988,42.014 -69.99,42.012</coordinates></LinearRing></innerBoundaryIs>
</Polygon>
</Placemark>
</Folder>
</Document>
</kml>
"#;

#[track_caller]
fn refused(text: &str) -> String {
    let error = Fence::from_kml(text, &TERMS).expect_err(text).to_string();
    assert!(!error.contains('\n'), "one line: {error}");
    error
}

/// Checks that the document with a part replaced throughout is refused with a message that begins like this.
#[track_caller]
fn refused_with(cases: &[(&str, &str, &str)]) {
    for (from, to, message) in cases {
        assert!(KML.contains(from), "{from}");
        let error = refused(&KML.replace(from, to));
        assert!(error.starts_with(message), "{error}\n{message}");
    }
}

#[track_caller]
fn read_with(from: &str, to: &str) -> Fence {
    assert!(KML.contains(from), "{from}");
    Fence::from_kml(&KML.replace(from, to), &TERMS).unwrap()
}

#[test]
fn the_unchanged_document_is_accepted() {
    let fence = Fence::from_kml(KML, &TERMS).unwrap();
    let zone = fence.zones().next().unwrap();
    assert_eq!((zone.name(), zone.margin_m()), ("box", 90.0));
    assert_eq!(zone.window().to_string(), "from 2026-05-01T08:00:00Z");
}

/// The elements whose loss would change the fence.
#[test]
fn a_misspelt_element_is_refused_everywhere() {
    for name in [
        "kml",
        "Document",
        "Folder",
        "Placemark",
        "name",
        "TimeSpan",
        "begin",
        "ExtendedData",
        "Data",
        "displayName",
        "value",
        "SchemaData",
        "SimpleData",
        "Polygon",
        "outerBoundaryIs",
        "innerBoundaryIs",
        "LinearRing",
        "coordinates",
    ] {
        let shorter = name[..name.len() - 1].to_owned();
        for wrong in [
            name.to_lowercase(),
            name.to_uppercase(),
            shorter,
            format!("{name}s"),
            format!("x{name}"),
        ] {
            if wrong == name {
                continue;
            }
            let mut text = KML.to_owned();
            for (start, end) in [("<", ">"), ("<", " "), ("</", ">")] {
                text = text.replace(&format!("{start}{name}{end}"), &format!("{start}{wrong}{end}"));
            }
            let error = refused(&text);
            assert!(
                error.starts_with("line ") && error.contains(&format!("<{wrong}>")),
                "{wrong}: {error}"
            );
        }
    }
}

#[test]
fn no_hole_is_lost() {
    let expected = "expected <outerBoundaryIs>, <innerBoundaryIs> or a drawing element such as <extrude>";
    for name in ["innerboundaryIs", "innerBoundary", "hole"] {
        let error = refused(&KML.replace("innerBoundaryIs", name));
        assert_eq!(error, format!("line 16: <{name}> in <Polygon>, {expected}"));
    }
    refused_with(&[
        (
            "<Polygon>",
            "<Polygon>hole",
            "line 12: text `hole` in <Polygon>, expected <outer",
        ),
        (
            "<innerBoundaryIs><LinearRing>",
            "<innerBoundaryIs/><innerBoundaryIs><LinearRing>",
            "line 16: empty <innerBoundaryIs>, expected <LinearRing>",
        ),
        (
            "<innerBoundaryIs><LinearRing>",
            "<innerBoundaryIs><Linearring/><LinearRing>",
            "line 16: <Linearring> in <innerBoundaryIs>, expected <LinearRing>",
        ),
        (
            "<coordinates>-69.99",
            "<coordinate/><coordinates>-69.99",
            "line 16: <coordinate> in <LinearRing>, expected <coordinates>",
        ),
        (
            "<coordinates>-69.99",
            "<coordinates/><coordinates>-69.99",
            "line 16: another <coordinates> in <LinearRing>, expected it only once",
        ),
        (
            "-69.988,42.012 ",
            "<at>-69.988,42.012</at> ",
            "line 16: <at> in <coordinates>, expected text only",
        ),
    ]);
    for drawn in [
        "<extrude>0</extrude><tessellate>1</tessellate><altitudeMode>clampToGround</altitudeMode>",
        "<gx:altitudeMode>clampToSeaFloor</gx:altitudeMode><gx:altitudeOffset>0</gx:altitudeOffset>",
    ] {
        let fence = read_with("<Polygon>", &format!("<Polygon>{drawn}"));
        assert_eq!(fence.zones().count(), 1);
        let _ = read_with("<LinearRing>", &format!("<LinearRing>{drawn}"));
    }
}

#[test]
fn no_placemark_is_lost() {
    let expected = "expected <Placemark>, <Document>, <Folder> or another element that KML 2.3 allows here";
    for (from, to, line) in [
        ("Placemark", "placemark", "line 4: <placemark> in <Folder>"),
        ("Placemark", "PlaceMark", "line 4: <PlaceMark> in <Folder>"),
        ("Folder", "folder", "line 3: <folder> in <Document>"),
        ("Document", "document", "line 2: <document> in <kml>"),
        ("Folder", "Layer", "line 3: <Layer> in <Document>"),
    ] {
        assert_eq!(refused(&KML.replace(from, to)), format!("{line}, {expected}"));
    }
    let within = "expected placemarks in <Document> and <Folder> only";
    for name in [
        "gx:Tour",
        "Style",
        "ExtendedData",
        "NetworkLinkControl",
        "GroundOverlay",
        "Metadata",
    ] {
        let text = KML.replace("Folder", name);
        let local = name.trim_start_matches("gx:");
        assert_eq!(refused(&text), format!("line 4: <Placemark> in <{local}>, {within}"));
        let deep = KML
            .replace("<Folder>", &format!("<{name}><a><b>"))
            .replace("</Folder>", &format!("</b></a></{name}>"));
        assert_eq!(
            refused(&deep.replace("Placemark", "PLACEMARK")),
            format!("line 4: <PLACEMARK> in <b>, {within}")
        );
    }
    refused_with(&[
        (
            "<name>box</name>",
            "<name>box</name>\n<Style><Placemark/></Style>",
            "line 6: <Placemark> in <Style>, expected",
        ),
        (
            "<name>box</name>",
            "<name>box</name>\n<Placemark/>",
            "line 6: <Placemark> in <Placemark>, expected",
        ),
        (
            "<Folder>",
            "<Folder>wreck",
            "line 3: text `wreck` in <Folder>, expected <Placemark>",
        ),
    ]);
}

#[test]
fn no_part_of_a_placemark_is_lost() {
    refused_with(&[
        (
            "ExtendedData>",
            "Extendeddata>",
            "line 7: <Extendeddata> in <Placemark>, expected a geometry, <ExtendedData>, <TimeSpan> or another element that KML 2.3 allows here",
        ),
        (
            "<Polygon>",
            "<polygon/>\n<Polygon>",
            "line 12: <polygon> in <Placemark>",
        ),
        ("<name>", "<Name/><name>", "line 5: <Name> in <Placemark>"),
        (
            "<name>",
            "<name>pier</name>\n<name>",
            "line 6: another <name> in <Placemark>, expected it only once",
        ),
        (
            "Polygon>",
            "MultiGeometry>",
            "line 13: <outerBoundaryIs> in <MultiGeometry>, expected <Polygon>",
        ),
        (
            "<name>box</name>",
            "<name>box<b/></name>",
            "line 5: <b> in <name>, expected text only",
        ),
        (
            "<name>box</name>",
            "<name>box\nbay</name>",
            "line 4 placemark 'box bay': `name` is \"box\\nbay\"",
        ),
    ]);
}

#[test]
fn no_time_is_lost() {
    let both = "expected <begin>, <end> or both";
    refused_with(&[
        (
            "TimeSpan>",
            "Timespan>",
            "line 6: <Timespan> in <Placemark>, expected a geometry",
        ),
        ("begin>", "Begin>", &format!("line 6: <Begin> in <TimeSpan>, {both}")),
        (
            "<begin>",
            "<End/><begin>",
            &format!("line 6: <End> in <TimeSpan>, {both}"),
        ),
        (
            "<begin>2026-05-01T08:00:00Z</begin>",
            "",
            &format!("line 6: empty <TimeSpan>, {both}"),
        ),
        (
            "<begin>2026-05-01T08:00:00Z</begin>",
            "2026-05-01T08:00:00Z",
            &format!("line 6: text `2026-05-01T08:00:00Z` in <TimeSpan>, {both}"),
        ),
        ("2026-05-01T08:00:00Z", " ", "line 6: empty <begin>, expected a time"),
        (
            "<begin>",
            "<begin>2026-05-01T09:00:00Z</begin><begin>",
            "line 6: another <begin> in <TimeSpan>, expected it only once",
        ),
        (
            "<TimeSpan>",
            "<TimeSpan><end>2026-05-02T08:00:00Z</end></TimeSpan>\n<TimeSpan>",
            "line 7: another <TimeSpan> in <Placemark>, expected it only once",
        ),
        (
            "TimeSpan>",
            "TimeStamp>",
            "line 4 placemark 'box': <TimeStamp>, expected <TimeSpan>",
        ),
        (
            "surfacing\">false",
            "valid_from\">2026-05-01T09:00:00Z",
            "line 4 placemark 'box': `valid_from` given twice",
        ),
    ]);
    // A time of a folder would apply to its placemarks.
    for (parent, line) in [("Folder", 3), ("Document", 2)] {
        for time in ["TimeSpan", "TimeStamp"] {
            let start = format!("<{parent}>");
            let error = refused(&KML.replace(&start, &format!("{start}<{time}><end>2026-05-02</end></{time}>")));
            assert_eq!(
                error,
                format!("line {line}: <{time}> in <{parent}>, expected <TimeSpan> in each <Placemark>")
            );
        }
    }
}

#[test]
fn no_property_is_lost() {
    let margin = "<displayName>Margin</displayName><value>90</value>";
    refused_with(&[
        (margin, "900", "line 9: text `900` in <Data>, expected one <value>"),
        (margin, "", "line 9: <Data> without <value>, expected one <value>"),
        (
            margin,
            "<displayName>900</displayName>",
            "line 9: <Data> without <value>, expected one <value>",
        ),
        (
            margin,
            "<Value>900</Value>",
            "line 9: <Value> in <Data>, expected one <value>",
        ),
        (
            margin,
            "<value>9</value><value>900</value>",
            "line 9: another <value> in <Data>, expected it only once",
        ),
        (
            margin,
            "<value><b>900</b></value>",
            "line 9: <b> in <value>, expected text only",
        ),
        (
            "SimpleData",
            "simpleData",
            "line 10: <simpleData> in <SchemaData>, expected <SimpleData>",
        ),
        (
            "SchemaData",
            "Schemadata",
            "line 10: <Schemadata> in <ExtendedData>, expected <Data> or <SchemaData>",
        ),
        (
            ">false</SimpleData>",
            "><value>true</value></SimpleData>",
            "line 10: <value> in <SimpleData>, expected text only",
        ),
        (
            "<ExtendedData>",
            "<ExtendedData>margin_m=900",
            "line 7: text `margin_m=900` in <ExtendedData>, expected <Data>",
        ),
    ]);
    // An empty column counts as absent.
    for value in ["<value/>", "<value> </value>"] {
        let fence = read_with(margin, value);
        assert_eq!(fence.zones().next().unwrap().margin_m(), 10.0);
    }
}

#[test]
fn text_outside_of_the_root_element_is_refused() {
    for (text, message) in [
        (
            format!("fence\n{KML}"),
            "line 1: text `fence` outside the root element, expected well-formed XML",
        ),
        (
            format!("{KML}\nfence"),
            "line 23: text `fence` outside the root element",
        ),
        (
            format!("{KML}<![CDATA[fence]]>"),
            "line 22: text `fence` outside the root element",
        ),
        (format!("&lt;{KML}"), "line 1: text `<` outside the root element"),
        (
            KML.replace("box", "b\0x"),
            "line 5: control character U+0000, expected well-formed XML",
        ),
        (format!("{KML}\0"), "line 22: control character U+0000"),
    ] {
        let error = refused(&text);
        assert!(error.starts_with(message), "{error}\n{message}");
    }
    let framed = format!("\u{feff}<?xml version=\"1.0\"?>\r\n<!-- a -->\r\n\t{KML}<!-- b -->\n\n");
    assert!(Fence::from_kml(&framed, &TERMS).is_ok());
}

/// A document as Google Earth writes it: with views, styles (also those of its web version) and a tour.
#[test]
fn a_document_of_google_earth_is_read() {
    let text = r##"<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2" xmlns:kml="http://www.opengis.net/kml/2.2" xmlns:atom="http://www.w3.org/2005/Atom">
<Document id="1">
	<name>range.kml</name>
	<visibility>1</visibility><open>1</open>
	<atom:author><atom:name>survey</atom:name></atom:author>
	<atom:link href="https://example.org"/>
	<address>quay</address><phoneNumber>1</phoneNumber>
	<Snippet maxLines="2"></Snippet><snippet/>
	<description><![CDATA[<b>the range</b>]]></description>
	<gx:balloonVisibility>0</gx:balloonVisibility>
	<Camera><longitude>-70</longitude><latitude>42</latitude></Camera>
	<gx:CascadingStyle kml:id="c"><styleUrl>https://example.org/c.kml#main</styleUrl><Style><BalloonStyle><displayMode>hide</displayMode></BalloonStyle></Style></gx:CascadingStyle>
	<Style id="s"><IconStyle><Icon><href>pin.png</href></Icon><hotSpot x="20" y="2" xunits="pixels" yunits="pixels"/></IconStyle><LineStyle><color>ff0000ff</color><gx:labelVisibility>1</gx:labelVisibility></LineStyle><PolyStyle><fill>0</fill></PolyStyle></Style>
	<StyleMap id="m">
		<Pair><key>normal</key><styleUrl>#s</styleUrl></Pair>
		<Pair><key>highlight</key><styleUrl>#s</styleUrl></Pair>
	</StyleMap>
	<ExtendedData><Data name="note"><value>a</value></Data></ExtendedData>
	<Region><LatLonAltBox><north>43</north><south>41</south><east>-69</east><west>-71</west></LatLonAltBox></Region>
	<Folder>
		<name>zones</name>
		<open>1</open>
		<LookAt><gx:TimeSpan><begin>2026-05-01</begin></gx:TimeSpan><longitude>-70</longitude><latitude>42</latitude><range>9000</range></LookAt>
		<Placemark id="2">
			<name>box</name>
			<visibility>0</visibility><open>1</open><snippet/><description>main &lt;b&gt;area&lt;/b&gt;</description>
			<LookAt>
				<longitude>-69.99</longitude><latitude>42.01</latitude><altitude>0</altitude>
				<heading>0</heading><tilt>0</tilt><gx:fovy>35</gx:fovy><range>9000</range>
				<gx:altitudeMode>relativeToSeaFloor</gx:altitudeMode>
			</LookAt>
			<styleUrl>#m</styleUrl>
			<Style><LineStyle><width>2</width></LineStyle></Style>
			<gx:Carousel><gx:Image kml:id="i"><gx:ImageUrl>a.png</gx:ImageUrl></gx:Image></gx:Carousel>
			<gx:balloonVisibility>1</gx:balloonVisibility>
			<ExtendedData><Data name="kind"><value>keep-in</value></Data></ExtendedData>
			<Polygon>
				<extrude>1</extrude>
				<tessellate>1</tessellate>
				<gx:altitudeMode>clampToSeaFloor</gx:altitudeMode>
				<outerBoundaryIs>
					<LinearRing>
						<coordinates>
							-70.0,42.0,0 -69.98,42.0,0 -69.98,42.02,0 -70.0,42.02,0 -70.0,42.0,0
						</coordinates>
					</LinearRing>
				</outerBoundaryIs>
			</Polygon>
		</Placemark>
		<Placemark>
			<name>wreck</name>
			<styleUrl>#m</styleUrl>
			<ExtendedData><Data name="kind"><value>keep-out</value></Data><Data name="radius_m"><value>50</value></Data></ExtendedData>
			<Point><gx:drawOrder>1</gx:drawOrder><altitudeMode>clampToGround</altitudeMode><coordinates>-69.99,42.01,0</coordinates></Point>
		</Placemark>
	</Folder>
	<GroundOverlay><name>chart</name><Icon><href>chart.png</href></Icon><LatLonBox><north>43</north></LatLonBox></GroundOverlay>
	<ScreenOverlay><name>logo</name></ScreenOverlay>
	<PhotoOverlay><name>quay</name><Point><coordinates>-70,42</coordinates></Point></PhotoOverlay>
	<gx:Tour><name>flight</name><gx:Playlist><gx:FlyTo><gx:duration>1</gx:duration></gx:FlyTo></gx:Playlist></gx:Tour>
</Document>
</kml>
"##;
    let fence = Fence::from_kml(text, &TERMS).unwrap();
    let names: Vec<_> = fence.zones().map(|zone| zone.name()).collect();
    assert_eq!(names, ["box", "wreck"]);
}

/// A layer as QGIS writes it through GDAL: with a schema, and a column for each attribute, of which many are empty.
#[test]
fn a_layer_of_qgis_is_read() {
    let text = r##"<?xml version="1.0" encoding="utf-8" ?>
<kml xmlns="http://www.opengis.net/kml/2.2">
<Document id="root_doc">
<Schema name="zones" id="zones">
	<SimpleField name="kind" type="string"></SimpleField>
	<SimpleField name="margin_m" type="float"><displayName>margin</displayName></SimpleField>
	<SimpleField name="radius_m" type="float"></SimpleField>
</Schema>
<Folder><name>zones</name>
  <Placemark id="zones.1">
	<name>box</name>
	<Style><LineStyle><color>ff0000ff</color></LineStyle><PolyStyle><fill>0</fill></PolyStyle></Style>
	<ExtendedData><SchemaData schemaUrl="#zones">
		<SimpleData name="kind">keep-in</SimpleData>
		<SimpleData name="margin_m">25</SimpleData>
		<SimpleData name="radius_m"></SimpleData>
		<SimpleData name="valid_from"/>
	</SchemaData></ExtendedData>
      <MultiGeometry><Polygon><altitudeMode>relativeToGround</altitudeMode><outerBoundaryIs><LinearRing><altitudeMode>relativeToGround</altitudeMode><coordinates>-70.0,42.0 -69.98,42.0 -69.98,42.02 -70.0,42.02 -70.0,42.0</coordinates></LinearRing></outerBoundaryIs></Polygon></MultiGeometry>
  </Placemark>
</Folder>
</Document></kml>
"##;
    let fence = Fence::from_kml(text, &TERMS).unwrap();
    let zone = fence.zones().next().unwrap();
    assert_eq!((zone.name(), zone.margin_m()), ("box", 25.0));
}
