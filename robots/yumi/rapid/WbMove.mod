MODULE WbMove
    ! One arm: does what T_LINK orders; loaded into both motion tasks.

    VAR syncident wb_turn;
    VAR syncident wb_begin;
    VAR syncident wb_hands;
    VAR syncident wb_sync_on;
    VAR syncident wb_sync_off;

    CONST num WB_FORCE:=10;
    CONST num WB_FINGER_SPEED:=20;
    CONST num WB_FINGER_STROKE:=25;
    CONST num WB_WIDTH_TOLERANCE:=2;
    CONST num WB_NEAR_HOME:=0.5;
    CONST num WB_PATIENCE:=60;
    CONST speeddata wb_slow:=[50,15,50,15];
    CONST speeddata wb_usual:=[250,90,250,90];

    ! The frame of the wrist, with the load of the tool: a plan sets it that states one.  For
    ! abb-socket, which states none, write the load of your tool here.
    TASK PERS tooldata wb_tool:=[TRUE,[[0,0,0],[1,0,0,0]],[0.001,[0,0,0.001],[1,0,0,0],0,0,0]];
    TASK PERS loaddata wb_payload:=[0.001,[0,0,0.001],[1,0,0,0],0,0,0];

    VAR bool has_gripped:=FALSE;
    VAR bool is_empty:=FALSE;

    ! Runs for ever. Begins anew when the operator sets the pointer to main.
    PROC wb_obey()
        VAR num last_order;

        wb_ready{my_arm}:=FALSE;
        ClearPath;
        wb_restarted{my_arm}:=TRUE;
        has_gripped:=FALSE;
        IF NOT Hand_IsCalibrated() THEN
            Hand_Initialize\maxSpd:=WB_FINGER_SPEED,\holdForce:=WB_FORCE,\Calibrate;
        ENDIF
        go_home_in_turn;
        last_order:=wb_order;
        wb_ended{my_arm}:=last_order;
        wb_ready{my_arm}:=TRUE;
        WHILE TRUE DO
            WaitUntil wb_order<>last_order\PollRate:=0.02;
            last_order:=wb_order;
            TEST wb_kind
            CASE WB_PROGRAM:
                run_program;
            CASE WB_SINGLE:
                run_single;
            DEFAULT:
                TPWrite "Workbench: unknown kind of order";
            ENDTEST
            wb_ended{my_arm}:=last_order;
        ENDWHILE
    ENDPROC

    ! Homing: one arm after the other, slowly, and only when the operator says so.
    PROC go_home_in_turn()
        WaitSyncTask wb_turn,wb_both;
        IF my_arm=WB_RIGHT go_home;
        WaitSyncTask wb_turn,wb_both;
        IF my_arm=WB_LEFT go_home;
        WaitSyncTask wb_turn,wb_both;
    ENDPROC

    PROC go_home()
        VAR num answer;

        IF is_near(CJointT(),my_home) RETURN;
        TPReadFK answer,"The "+my_name+" arm is not at home. Move it there?","Move",stEmpty,stEmpty,stEmpty,"Stay";
        IF answer=1 MoveAbsJ my_home,wb_slow,fine,wb_tool;
    ENDPROC

    FUNC bool is_near(jointtarget here,jointtarget there)
        VAR num off;

        off:=Abs(here.robax.rax_1-there.robax.rax_1);
        off:=off+Abs(here.robax.rax_2-there.robax.rax_2);
        off:=off+Abs(here.robax.rax_3-there.robax.rax_3);
        off:=off+Abs(here.robax.rax_4-there.robax.rax_4);
        off:=off+Abs(here.robax.rax_5-there.robax.rax_5);
        off:=off+Abs(here.robax.rax_6-there.robax.rax_6);
        off:=off+Abs(here.extax.eax_a-there.extax.eax_a);
        RETURN off<WB_NEAR_HOME;
    ENDFUNC

    ! abb-socket/2: all steps; both arms stand while hands open and close.  Where a step
    ! waits for a word they stand before that, for as long as it takes.
    PROC run_program()
        VAR num leg;

        IF wb_has_load{my_arm,WB_OF_TOOL} wb_tool.tload:=wb_load{my_arm,WB_OF_TOOL};
        FOR nr FROM 1 TO wb_steps DO
            WaitSyncTask\InPos,wb_begin,wb_both\TimeOut:=WB_PATIENCE;
            wb_at{my_arm}:=0;
            wb_asks{my_arm}:=nr;
            IF wb_let<nr WaitUntil wb_let>=nr\PollRate:=0.02;
            wb_step{my_arm}:=nr;
            leg:=leg_of(nr);
            IF leg>0 move_fingers wb_leg_hand{my_arm,leg},wb_leg_opening{my_arm,leg};
            WaitSyncTask wb_hands,wb_both\TimeOut:=WB_PATIENCE;
            IF leg>0 run_leg leg;
        ENDFOR
        WaitSyncTask\InPos,wb_begin,wb_both\TimeOut:=WB_PATIENCE;
    ERROR
        IF ERRNO=ERR_WAITSYNCTASK THEN
            TPWrite "Workbench: the other arm does not come";
            StopMove;
            Stop;
        ENDIF
        RAISE;
    ENDPROC

    ! An arm may have none: FOR counts down when the end is less than the beginning.
    FUNC num leg_of(num nr)
        IF wb_legs{my_arm}=0 RETURN 0;
        FOR leg FROM 1 TO wb_legs{my_arm} DO
            IF wb_leg_step{my_arm,leg}=nr RETURN leg;
        ENDFOR
        RETURN 0;
    ENDFUNC

    PROC run_leg(num leg)
        VAR num first;
        VAR num last;
        VAR bool is_sync;
        VAR zonedata corner;

        first:=wb_leg_first{my_arm,leg};
        last:=wb_leg_last{my_arm,leg};
        is_sync:=wb_leg_mode{my_arm,leg}=WB_SYNC;
        IF is_sync SyncMoveOn wb_sync_on,wb_both\TimeOut:=WB_PATIENCE;
        FOR k FROM first TO last DO
            wb_at{my_arm}:=k-first+1;
            IF k=last THEN
                corner:=fine;
            ELSE
                corner:=corner_at(k,wb_leg_zone{my_arm,leg});
            ENDIF
            IF is_sync THEN
                MoveAbsJ wb_point{my_arm,k}\ID:=k-first+1,wb_usual\T:=wb_seconds{my_arm,k},corner,wb_tool;
            ELSE
                MoveAbsJ wb_point{my_arm,k},wb_usual\T:=wb_seconds{my_arm,k},corner,wb_tool;
            ENDIF
        ENDFOR
        IF is_sync SyncMoveOff wb_sync_off;
    ERROR
        RAISE;
    UNDO
        SyncMoveUndo;
    ENDPROC

    ! The rounding of a corner, as a share of the shorter segment beside it.
    FUNC zonedata corner_at(num k,num share)
        VAR robtarget before;
        VAR robtarget here;
        VAR robtarget after;
        VAR num size;
        VAR zonedata corner;

        IF share=0 RETURN fine;
        before:=CalcRobT(wb_point{my_arm,k-1},tool0);
        here:=CalcRobT(wb_point{my_arm,k},tool0);
        after:=CalcRobT(wb_point{my_arm,k+1},tool0);
        size:=Distance(before.trans,here.trans);
        IF Distance(here.trans,after.trans)<size size:=Distance(here.trans,after.trans);
        size:=size*share;
        corner:=z0;
        corner.pzone_tcp:=size;
        corner.pzone_ori:=size;
        corner.pzone_eax:=size;
        RETURN corner;
    ENDFUNC

    ! abb-socket: one motion of one arm, to rest.
    PROC run_single()
        IF wb_mover<>my_arm RETURN;
        move_fingers wb_hand,2*WB_FINGER_STROKE;
        IF wb_moves MoveAbsJ wb_target,wb_usual,fine,wb_tool;
    ERROR
        RAISE;
    ENDPROC

    ! The Smart Gripper counts what one finger travels: half of the opening.
    PROC move_fingers(num hand,num opening)
        TEST hand
        CASE WB_OPEN:
            IF has_gripped judge_part;
            has_gripped:=FALSE;
            Hand_MoveTo opening/2;
            GripLoad load0;
        CASE WB_GRIP:
            Hand_GripInward\holdForce:=WB_FORCE;
            has_gripped:=TRUE;
            IF wb_kind=WB_PROGRAM AND wb_has_load{my_arm,WB_OF_PART} THEN
                wb_payload:=wb_load{my_arm,WB_OF_PART};
                GripLoad wb_payload;
            ENDIF
            wb_expected{my_arm}:=opening;
            wb_width{my_arm}:=2*Hand_GetActualPos();
            is_empty:=wb_width{my_arm}<=WB_WIDTH_TOLERANCE;
        DEFAULT:
            RETURN;
        ENDTEST
    ERROR
        TPWrite "Workbench: the hand of the "+my_name+" arm has a fault";
        RAISE;
    ENDPROC

    ! Before the hand lets go: narrower than the part is nothing, or lost. Missed is a hand that
    ! has closed all the way at once.
    PROC judge_part()
        VAR num width;

        width:=2*Hand_GetActualPos();
        IF width<wb_width{my_arm} wb_width{my_arm}:=width;
        IF wb_width{my_arm}>=wb_expected{my_arm}-WB_WIDTH_TOLERANCE THEN
            wb_part{my_arm}:=WB_PICKED;
        ELSEIF is_empty THEN
            wb_part{my_arm}:=WB_MISSED;
        ELSE
            wb_part{my_arm}:=WB_FAILED;
        ENDIF
    ENDPROC
ENDMODULE
