//! What is made from the tables.
