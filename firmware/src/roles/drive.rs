//! What axle and screw share: objects of CiA 402.
