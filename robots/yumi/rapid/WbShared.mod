MODULE WbShared
    ! Data that the tasks share; loaded into all three.
    ! Arms are counted: 1 is the right one, 2 the left one.

    CONST num WB_RIGHT:=1;
    CONST num WB_LEFT:=2;
    CONST num WB_MOST_POINTS:=400;
    CONST num WB_MOST_LEGS:=24;

    PERS tasks wb_both{2}:=[["T_ROB_R"],["T_ROB_L"]];

    ! An order is given by counting wb_order up, and is done when wb_ended has
    ! the same number.
    CONST num WB_PROGRAM:=1;
    CONST num WB_SINGLE:=2;
    PERS num wb_order:=0;
    PERS num wb_kind:=0;
    PERS num wb_ended{2}:=[0,0];
    PERS bool wb_restarted{2}:=[FALSE,FALSE];

    ! Whether an arm has come home since its pointer was set to main: an order
    ! that is given before would be lost.
    PERS bool wb_ready{2}:=[FALSE,FALSE];

    ! A program of abb-socket/2. The first point of an arm is where it starts.
    CONST num WB_ALONE:=1;
    CONST num WB_FREE:=2;
    CONST num WB_SYNC:=3;
    CONST num WB_KEEP:=0;
    CONST num WB_OPEN:=1;
    CONST num WB_GRIP:=2;
    PERS num wb_steps:=0;

    ! The step up to which the arms may go: all of them, or step by step the last
    ! one that somebody has let run; and the step that each arm has come to.
    PERS num wb_let:=0;
    PERS num wb_asks{2}:=[0,0];
    PERS num wb_legs{2}:=[0,0];
    PERS num wb_points{2}:=[0,0];
    PERS num wb_leg_step{2,24};
    PERS num wb_leg_first{2,24};
    PERS num wb_leg_last{2,24};
    PERS num wb_leg_zone{2,24};
    PERS num wb_leg_hand{2,24};
    PERS num wb_leg_opening{2,24};
    PERS num wb_leg_mode{2,24};
    PERS jointtarget wb_point{2,400};
    PERS num wb_seconds{2,400};

    ! The loads of a program, by arm: of the tool, and of the part in it.  Without them the
    ! tool has the load that wb_tool in WbMove says.
    CONST num WB_OF_TOOL:=1;
    CONST num WB_OF_PART:=2;
    PERS bool wb_has_load{2,2}:=[[FALSE,FALSE],[FALSE,FALSE]];
    PERS loaddata wb_load{2,2};

    ! A single motion of abb-socket.
    PERS num wb_mover:=1;
    PERS bool wb_moves:=FALSE;
    PERS num wb_hand:=0;
    PERS jointtarget wb_target;

    ! What the arms report.
    CONST num WB_UNTOLD:=0;
    CONST num WB_PICKED:=1;
    CONST num WB_FAILED:=2;
    CONST num WB_MISSED:=3;
    PERS num wb_step{2}:=[0,0];
    PERS num wb_at{2}:=[0,0];
    PERS num wb_part{2}:=[0,0];
    PERS num wb_width{2}:=[0,0];
    PERS num wb_expected{2}:=[0,0];
ENDMODULE
