//! The plugins of missions.

mod components;
